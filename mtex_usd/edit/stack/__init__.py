"""Stacks of edits as they are declared on an animation (Gleicher 2000, sections 1.5 and 1.6).

An :class:`~mtex_usd.edit.stack.edit.Edit` names an operation and its settings, and
:func:`~mtex_usd.edit.stack.run.run_stack` runs several in order. What each does is a plain function of
:mod:`mtex_usd.edit`; here settings in time codes become arguments in frames and seconds. Nothing is imported here, so
that reading what is declared does not wait for what carries it out.
"""
