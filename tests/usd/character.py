"""A stage as text: an oriented, placed rig and an animation of some of its joints."""

__all__ = ["CHARACTER"]

CHARACTER = """#usda 1.0
(
    metersPerUnit = 0.1
    upAxis = "Z"
    timeCodesPerSecond = 48
    framesPerSecond = 24
)
def SkelRoot "Hero"
{
    def Skeleton "Rig" (prepend apiSchemas = ["SkelBindingAPI"])
    {
        rel skel:animationSource = </Hero/Walk>
        uniform token[] joints = ["L", "L/Hand", "R", "R/Hand"]
        uniform matrix4d[] restTransforms = [
            ((0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (1, 2, 3, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (4, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (5, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (6, 0, 0, 1))]
        uniform matrix4d[] bindTransforms = [
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (1, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (2, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (3, 0, 0, 1)),
            ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (4, 0, 0, 1))]
        double3 xformOp:translate = (0, 7, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def SkelAnimation "Walk"
    {
        uniform token[] joints = ["R/Hand", "L"]
        quatf[] rotations.timeSamples = {
            10: [(1, 0, 0, 0), (0.8, 0.6, 0, 0)], 12: [(1, 0, 0, 0), (0.6, 0.8, 0, 0)], 14: [(1, 0, 0, 0), (0, 1, 0, 0)]
        }
        float3[] translations = [(9, 9, 9), (8, 8, 8)]
        half3[] scales = [(1, 1, 1), (1, 2, 1)]
    }
}
"""
