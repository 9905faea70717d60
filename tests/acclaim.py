"""Small ASF/AMC files as text, to be read and to be damaged."""

from pathlib import Path

ASF = """# made for a test
:version 1.10
:name tester
:units
  mass 1.0
  length 0.5
  angle deg
:documentation
   anything : goes here
   begin end
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name thigh
     direction 0 -1 0
     length 4
     axis 0 0 20 XYZ
     dof rx ry rz
     limits (-160.0 20.0)
            (-70.0 70.0)
            (-inf 70.0)
     bodymass 2
  end
  begin
     id 2
     name shin
     direction 0.6 -0.8 0
     length 5
     axis 10 20 30 ZXY
     dof rx
  end
  begin
     id 3
     name spine
     direction 0 2 0
     length 3
     axis 0 0 0 XYZ
  end
:hierarchy
  begin
    root thigh spine
    thigh shin
  end
"""

AMC = """#!OML:ASF tester.asf
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 10 20 30
thigh 5 -6 7
shin 40
2
root 1.5 2 3 11 21 31
thigh 6 -7 8
shin 41
"""


def write_take(folder: Path, *, asf: str = ASF, amc: str = AMC) -> Path:
    """Write both files; give the motion's."""
    (folder / "tester.asf").write_text(asf)
    (folder / "tester_01.amc").write_text(amc)
    return folder / "tester_01.amc"
