"""Which animations are sketches, and which takes they name."""

import pytest
from pxr import Sdf, Usd

from mtex_usd.errors import InputError, StageError
from mtex_usd.usd.recipe_targets import find_sketches, find_takes, is_own_output
from tests.usd.animation_support import apply_recipe, author_animation, define, new_layer, stage_of
from tests.usd.schema_support import run_python


def paths(prims):
    return [str(prim.GetPath()) for prim in prims]


def shot(*, takes=("/Takes",)):
    layer = new_layer()
    author_animation(layer, "/Char/Sketch", [1, 2], recipe=True, takes=takes)
    author_animation(layer, "/Char/Idle", [1, 2])
    for name in ("walk", "run"):
        author_animation(layer, f"/Takes/{name}", [1, 2])
    return layer


def add_output(layer, prim_path, *, custom_data=True):
    """Author what the override layer does: references the sketch, takes the recipe off."""
    spec = define(layer, prim_path, "SkelAnimation")
    spec.referenceList.prependedItems = [Sdf.Reference("", "/Char/Sketch")]
    spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(deletedItems=["MtexSketchAPI"]))
    if custom_data:
        spec.SetInfo("customData", {"mtex": {"rank": 1}})


class TestFindSketches:
    def test_every_animation_with_a_recipe(self):
        layer = shot()
        author_animation(layer, "/Second/Sketch", [1, 2], recipe=True)
        define(layer, "/Char/Mesh", "Mesh").SetInfo(
            "apiSchemas", Sdf.TokenListOp.Create(prependedItems=["MtexSketchAPI"])
        )
        assert paths(find_sketches(stage_of(layer))) == ["/Char/Sketch", "/Second/Sketch"]

    def test_instance_proxies(self):
        library, root = shot(takes=["/Char/Idle"]), new_layer()
        stage = stage_of(root)
        for name in ("A", "B"):
            prim = stage.DefinePrim(f"/{name}")
            prim.GetReferences().AddReference(library.identifier, "/Char")
            prim.SetInstanceable(True)
        sketches = find_sketches(stage)
        assert paths(sketches) == ["/A/Sketch", "/B/Sketch"]
        assert [paths(find_takes(stage, sketch)) for sketch in sketches] == [["/A/Idle"], ["/B/Idle"]]

    @pytest.mark.parametrize("custom_data", [True, False])
    def test_our_own_results_are_none(self, custom_data):
        layer = shot(takes=["/Char"])
        add_output(layer, "/Char/Sketch_mtex", custom_data=custom_data)
        stage = stage_of(layer)
        assert is_own_output(stage.GetPrimAtPath("/Char/Sketch_mtex"))
        assert paths(find_sketches(stage)) == ["/Char/Sketch"]
        assert paths(find_takes(stage, stage.GetPrimAtPath("/Char/Sketch"))) == ["/Char/Idle"]

    def test_a_name_alone_does_not_make_a_result(self):
        layer = shot(takes=["/Takes"])
        author_animation(layer, "/Takes/hop_mtex", [1, 2])
        stage = stage_of(layer)
        assert paths(find_takes(stage, find_sketches(stage)[0])) == ["/Takes/walk", "/Takes/run", "/Takes/hop_mtex"]

    def test_only_the_named_ones_once_in_the_order_named(self):
        layer = shot()
        author_animation(layer, "/Second/Sketch", [1, 2], recipe=True)
        stage = stage_of(layer)
        named = ["/Second/Sketch", "/Char/Sketch", "/Second/Sketch"]
        assert paths(find_sketches(stage, only=named)) == ["/Second/Sketch", "/Char/Sketch"]
        assert paths(find_sketches(stage, only=["/Char/Sketch"])) == ["/Char/Sketch"]

    @pytest.mark.parametrize(
        ("prim_path", "found"), [("/Nowhere", "no such prim"), ("no path", "no such prim"), ("/Char", "Scope")]
    )
    def test_named_but_no_animation(self, prim_path, found):
        pattern = rf"cannot take {prim_path} as a sketch; expected a SkelAnimation; found {found}.*stage: /Char/Sketch"
        with pytest.raises(InputError, match=pattern):
            find_sketches(stage_of(shot()), only=["/Char/Sketch", prim_path])

    def test_named_but_without_recipe(self):
        pattern = r"/Char/Idle has no recipe; expected MtexSketchAPI applied. The sketches of this stage: /Char/Sketch"
        with pytest.raises(StageError, match=pattern):
            find_sketches(stage_of(shot()), only=["/Char/Idle"])

    def test_named_but_our_own_result(self):
        layer = shot()
        add_output(layer, "/Char/Sketch_mtex")
        with pytest.raises(StageError, match=r"/Char/Sketch_mtex is what this tool wrote.*stage: /Char/Sketch"):
            find_sketches(stage_of(layer), only=["/Char/Sketch_mtex"])

    def test_no_recipe_lists_the_animations_there_are(self):
        layer = new_layer()
        author_animation(layer, "/Char/Idle", [1, 2])
        with pytest.raises(StageError, match=r"has no recipe.*MtexSketchAPI applied; found /Char/Idle. Apply"):
            find_sketches(stage_of(layer))
        with pytest.raises(StageError, match=r"has no recipe.*found no SkelAnimation"):
            find_sketches(Usd.Stage.CreateInMemory())

    def test_without_the_schema_in_the_process(self, tmp_path):
        file = tmp_path / "shot.usda"
        shot().Export(str(file))
        code = f"""
from pxr import Usd
Usd.Stage.CreateInMemory().DefinePrim("/TooEarly", "Xform")
from mtex_usd.usd.plugin import registration_status
from mtex_usd.usd.recipe_targets import find_sketches, find_takes
stage = Usd.Stage.Open({str(file)!r})
sketch = find_sketches(stage)[0]
print(registration_status().registered, sketch.GetPath(), *(take.GetPath() for take in find_takes(stage, sketch)))
"""
        assert run_python(code) == "False /Char/Sketch /Takes/walk /Takes/run"


class TestFindTakes:
    def find(self, layer):
        stage = stage_of(layer)
        return find_takes(stage, stage.GetPrimAtPath("/Char/Sketch"))

    def test_animations_at_and_below_the_targets_each_once(self):
        assert paths(self.find(shot(takes=["/Takes/run", "/Takes"]))) == ["/Takes/run", "/Takes/walk"]

    def test_sketches_are_no_takes(self):
        layer = shot(takes=["/Char", "/Takes"])
        assert paths(self.find(layer)) == ["/Char/Idle", "/Takes/walk", "/Takes/run"]

    def test_targets_are_forwarded(self):
        layer = shot(takes=["/Sets/walks.takes"])
        relationship = Sdf.RelationshipSpec(define(layer, "/Sets/walks", "Scope"), "takes", custom=True)
        relationship.targetPathList.explicitItems = [Sdf.Path("/Takes/walk")]
        assert paths(self.find(layer)) == ["/Takes/walk"]

    def test_takes_inside_instances(self):
        library, layer = shot(), shot(takes=["/Library"])
        prim = define(layer, "/Library", "")
        prim.referenceList.prependedItems = [Sdf.Reference(library.identifier, "/Takes")]
        prim.SetInfo("instanceable", True)
        stage = stage_of(layer)
        takes = find_takes(stage, stage.GetPrimAtPath("/Char/Sketch"))
        assert paths(takes) == ["/Library/walk", "/Library/run"]
        assert all(take.IsInstanceProxy() for take in takes)

    def test_no_takes_named(self):
        layer = shot()
        sketch = layer.GetPrimAtPath("/Char/Sketch")
        sketch.relationships["mtex:takes"].targetPathList.explicitItems = []
        sketch.relationships["mtex:takes"].targetPathList.ClearEditsAndMakeExplicit()
        with pytest.raises(StageError, match=r"/Char/Sketch.mtex:takes has no targets"):
            self.find(layer)
        del sketch.properties["mtex:takes"]
        with pytest.raises(StageError, match=r"/Char/Sketch names no takes; expected targets of mtex:takes"):
            self.find(layer)

    def test_target_that_is_not_there(self):
        with pytest.raises(StageError, match=r"/Char/Sketch.mtex:takes names a prim that is not there; found /Taeks"):
            self.find(shot(takes=["/Takes", "/Taeks"]))

    def test_target_without_any_animation(self):
        layer = shot(takes=["/Empty"])
        define(layer, "/Empty", "Scope")
        with pytest.raises(StageError, match=r"no take at or below /Empty; expected a SkelAnimation; found none"):
            self.find(layer)

    def test_target_with_only_sketches_and_results(self):
        layer = shot(takes=["/Char/Sketch", "/Takes"])
        pattern = r"no take at or below /Char/Sketch; expected a SkelAnimation; found /Char/Sketch, sketches or results"
        with pytest.raises(StageError, match=pattern):
            self.find(layer)


class TestDroppedTargets:
    """A referenced layer cannot name what lies outside the referenced prim: USD drops it with a warning."""

    def reference(self, library, prim_path="/Shot", *, source="/Char"):
        root = new_layer("root.usda")
        stage = stage_of(root)
        stage.DefinePrim(prim_path).GetReferences().AddReference(library.identifier, source)
        return root, stage

    def assert_dropped(self, stage, sketch_path, library, target="/Takes"):
        pattern = (
            rf"{sketch_path}.mtex:takes: composition dropped the target {target}; found it in layer "
            rf"{library.identifier}, of which only /Char is referenced. Author mtex:takes in the referencing layer"
        )
        with pytest.raises(StageError, match=pattern):
            find_takes(stage, stage.GetPrimAtPath(sketch_path))

    def test_outside_the_referenced_prim(self):
        library = shot()
        _, stage = self.reference(library)
        self.assert_dropped(stage, "/Shot/Sketch", library)

    def test_one_of_several(self):
        library = shot(takes=["/Char/Idle", "/Takes"])
        _, stage = self.reference(library)
        self.assert_dropped(stage, "/Shot/Sketch", library)

    def test_inside_an_instance(self):
        library = shot()
        _, stage = self.reference(library)
        stage.GetPrimAtPath("/Shot").SetInstanceable(True)
        assert stage.GetPrimAtPath("/Shot/Sketch").IsInstanceProxy()
        self.assert_dropped(stage, "/Shot/Sketch", library)

    def test_in_a_sublayer_of_the_referenced_layer(self):
        sublayer, library = shot(), new_layer("library.usda")
        library.subLayerPaths.append(sublayer.identifier)
        _, stage = self.reference(library)
        self.assert_dropped(stage, "/Shot/Sketch", sublayer)

    def test_inside_a_variant(self):
        library = shot(takes=["/Char/Idle"])
        del library.GetPrimAtPath("/Char/Sketch").properties["mtex:takes"]
        asset = stage_of(library)
        prim = asset.GetPrimAtPath("/Char")
        variants = prim.GetVariantSets().AddVariantSet("recipe")
        variants.AddVariant("rough")
        variants.SetVariantSelection("rough")
        with variants.GetVariantEditContext():
            sketch = asset.OverridePrim("/Char/Sketch")
            sketch.CreateRelationship("mtex:takes", custom=False).SetTargets(["/Takes", "/Char/Idle"])
        _, stage = self.reference(library)
        self.assert_dropped(stage, "/Shot/Sketch", library)

    def test_inherited_from_a_class(self):
        library = shot()
        sketch = library.GetPrimAtPath("/Char/Sketch")
        del sketch.properties["mtex:takes"]
        sketch.inheritPathList.prependedItems = [Sdf.Path("/_Recipe")]
        recipe = define(library, "/_Recipe", "Scope")
        recipe.specifier = Sdf.SpecifierClass
        apply_recipe(recipe, ["/Takes"])
        assert paths(find_takes(stage := stage_of(library), stage.GetPrimAtPath("/Char/Sketch")))[0] == "/Takes/walk"
        _, stage = self.reference(library)
        self.assert_dropped(stage, "/Shot/Sketch", library)

    def test_targets_inside_the_referenced_prim_are_mapped(self):
        _, stage = self.reference(shot(takes=["/Char/Idle"]))
        assert paths(find_takes(stage, stage.GetPrimAtPath("/Shot/Sketch"))) == ["/Shot/Idle"]

    def test_a_stronger_layer_that_names_takes_mends_it(self):
        library = shot()
        root, stage = self.reference(library)
        author_animation(root, "/Mocap/jump", [1, 2])
        stage.GetPrimAtPath("/Shot/Sketch").CreateRelationship("mtex:takes", custom=False).SetTargets(["/Mocap"])
        assert paths(find_takes(stage, stage.GetPrimAtPath("/Shot/Sketch"))) == ["/Mocap/jump"]

    def test_a_stronger_layer_that_only_adds_does_not(self):
        library = shot()
        root, stage = self.reference(library)
        author_animation(root, "/Mocap/jump", [1, 2])
        stage.GetPrimAtPath("/Shot/Sketch").CreateRelationship("mtex:takes", custom=False).AddTarget("/Mocap")
        self.assert_dropped(stage, "/Shot/Sketch", library)

    def test_the_whole_layer_as_sublayer_is_fine(self):
        library, root = shot(), new_layer()
        root.subLayerPaths.append(library.identifier)
        stage = stage_of(root)
        assert paths(find_takes(stage, find_sketches(stage)[0])) == ["/Takes/walk", "/Takes/run"]


def test_apply_recipe_is_what_the_schema_says():
    """The helper authors the property as the schema defines it."""
    layer = new_layer()
    apply_recipe(define(layer, "/Anim", "SkelAnimation"), ["/Takes"])
    stage = stage_of(layer)
    relationship = stage.GetPrimAtPath("/Anim").GetRelationship("mtex:takes")
    assert not relationship.IsCustom()
    assert relationship.GetTargets() == [Sdf.Path("/Takes")]
