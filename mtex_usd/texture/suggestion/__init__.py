"""Which match channels and band to choose, by finding takes again that are held out."""

from mtex_usd.texture.suggestion.choices import Choice
from mtex_usd.texture.suggestion.measuring import Score
from mtex_usd.texture.suggestion.ranking import Ranked, rank_choices
from mtex_usd.texture.suggestion.task import Task, evaluate_choice, set_task

__all__ = ["Choice", "Ranked", "Score", "Task", "evaluate_choice", "rank_choices", "set_task"]
