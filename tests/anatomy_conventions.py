"""Joint names of common rigs as their makers document them, with the part each joint begins.

``{}`` stands for the side, ``@`` for its name in the part; a block that has them is there for both sides.
"""

from tests.anatomy_support import both_sides

HUMAN_IK = """
Reference
  Hips = hips
    {}UpLeg = @.thigh
      {}UpLegRoll
      {}Leg = @.shin
        {}LegRoll
        {}Foot = @.foot
          {}ToeBase = @.toes
    Spine
      Spine1
        Spine2 = chest
          Neck = neck
            Neck1
              Head = head
          {}Shoulder = @.clavicle
            {}Arm = @.upperArm
              {}ArmRoll
              {}ForeArm = @.foreArm
                {}ForeArmRoll
                {}Hand = @.hand
                  {}HandThumb1 = @.thumb1
                    {}HandThumb2 = @.thumb2
                      {}HandThumb3 = @.thumb3
                        {}HandThumb4
                  {}InHandIndex
                    {}HandIndex1 = @.index1
                      {}HandIndex2 = @.index2
                        {}HandIndex3 = @.index3
                          {}HandIndex4
                  {}InHandPinky
                    {}HandPinky1 = @.pinky1
                      {}HandPinky2 = @.pinky2
                        {}HandPinky3 = @.pinky3
"""

MIXAMO = """
Hips = hips
  Spine
    Spine1
      Spine2 = chest
        Neck = neck
          Head = head
            HeadTop_End
            LeftEye
        {}Shoulder = @.clavicle
          {}Arm = @.upperArm
            {}ForeArm = @.foreArm
              {}Hand = @.hand
                {}HandThumb1 = @.thumb1
                  {}HandThumb2 = @.thumb2
                    {}HandThumb3 = @.thumb3
                      {}HandThumb4
                {}HandMiddle1 = @.middle1
                  {}HandMiddle2 = @.middle2
                    {}HandMiddle3 = @.middle3
                      {}HandMiddle4
                {}HandRing1 = @.ring1
                  {}HandRing2 = @.ring2
                    {}HandRing3 = @.ring3
  {}UpLeg = @.thigh
    {}Leg = @.shin
      {}Foot = @.foot
        {}ToeBase = @.toes
          {}Toe_End
"""

UNREAL = """
root
  pelvis = hips
    spine_01
      spine_02
        spine_03 = chest
          clavicle_{} = @.clavicle
            upperarm_{} = @.upperArm
              lowerarm_{} = @.foreArm
                hand_{} = @.hand
                  index_metacarpal_{}
                    index_01_{} = @.index1
                      index_02_{} = @.index2
                        index_03_{} = @.index3
                  pinky_01_{} = @.pinky1
                    pinky_02_{} = @.pinky2
                      pinky_03_{} = @.pinky3
                  thumb_01_{} = @.thumb1
                    thumb_02_{} = @.thumb2
                      thumb_03_{} = @.thumb3
                lowerarm_twist_01_{}
              upperarm_twist_01_{}
          neck_01 = neck
            head = head
    thigh_{} = @.thigh
      calf_{} = @.shin
        calf_twist_01_{}
        foot_{} = @.foot
          ball_{} = @.toes
      thigh_twist_01_{}
  ik_foot_root
    ik_foot_{}
  ik_hand_root
    ik_hand_gun
      ik_hand_{}
"""

VRM = """
hips = hips
  spine
    chest
      upperChest = chest
        neck = neck
          head = head
            leftEye
            rightEye
            jaw
        {}Shoulder = @.clavicle
          {}UpperArm = @.upperArm
            {}LowerArm = @.foreArm
              {}Hand = @.hand
                {}ThumbMetacarpal = @.thumb1
                  {}ThumbProximal = @.thumb2
                    {}ThumbDistal = @.thumb3
                {}IndexProximal = @.index1
                  {}IndexIntermediate = @.index2
                    {}IndexDistal = @.index3
                {}LittleProximal = @.pinky1
                  {}LittleIntermediate = @.pinky2
                    {}LittleDistal = @.pinky3
  {}UpperLeg = @.thigh
    {}LowerLeg = @.shin
      {}Foot = @.foot
        {}Toes = @.toes
"""

VROID = """
Root
  J_Bip_C_Hips = hips
    J_Bip_C_Spine
      J_Bip_C_Chest
        J_Bip_C_UpperChest = chest
          J_Sec_L_Bust1
          J_Bip_C_Neck = neck
            J_Bip_C_Head = head
              J_Adj_L_FaceEye
              J_Sec_Hair1_01
          J_Bip_{}_Shoulder = @.clavicle
            J_Bip_{}_UpperArm = @.upperArm
              J_Bip_{}_LowerArm = @.foreArm
                J_Bip_{}_Hand = @.hand
                  J_Bip_{}_Thumb1 = @.thumb1
                    J_Bip_{}_Thumb2 = @.thumb2
                      J_Bip_{}_Thumb3 = @.thumb3
                  J_Bip_{}_Little1 = @.pinky1
                    J_Bip_{}_Little2 = @.pinky2
                      J_Bip_{}_Little3 = @.pinky3
                        J_Bip_{}_Little3_end
    J_Bip_{}_UpperLeg = @.thigh
      J_Bip_{}_LowerLeg = @.shin
        J_Bip_{}_Foot = @.foot
          J_Bip_{}_ToeBase = @.toes
"""

BIPED = """
Bip01
  Bip01 Footsteps
  Bip01 Pelvis = hips
    Bip01 Spine
      Bip01 Spine1
        Bip01 Spine2 = chest
          Bip01 Neck = neck
            Bip01 {} Clavicle = @.clavicle
              Bip01 {} UpperArm = @.upperArm
                Bip01 {} Forearm = @.foreArm
                  Bip01 {} Hand = @.hand
                    Bip01 {} Finger0 = @.thumb1
                      Bip01 {} Finger01 = @.thumb2
                        Bip01 {} Finger02 = @.thumb3
                          Bip01 {} Finger0Nub
                    Bip01 {} Finger1 = @.index1
                      Bip01 {} Finger11 = @.index2
                        Bip01 {} Finger12 = @.index3
                    Bip01 {} Finger4 = @.pinky1
                      Bip01 {} Finger41 = @.pinky2
                        Bip01 {} Finger4Nub
            Bip01 Head = head
              Bip01 HeadNub
      Bip01 {} Thigh = @.thigh
        Bip01 {} Calf = @.shin
          Bip01 {} Foot = @.foot
            Bip01 {} Toe0 = @.toes
              Bip01 {} Toe0Nub
"""

VALVE = """
ValveBiped.Bip01_Pelvis = hips
  ValveBiped.Bip01_Spine
    ValveBiped.Bip01_Spine1
      ValveBiped.Bip01_Spine2
        ValveBiped.Bip01_Spine4 = chest
          ValveBiped.Bip01_Neck1 = neck
            ValveBiped.Bip01_Head1 = head
          ValveBiped.Bip01_{}_Clavicle = @.clavicle
            ValveBiped.Bip01_{}_UpperArm = @.upperArm
              ValveBiped.Bip01_{}_Forearm = @.foreArm
                ValveBiped.Bip01_{}_Hand = @.hand
                  ValveBiped.Bip01_{}_Finger0 = @.thumb1
                    ValveBiped.Bip01_{}_Finger01 = @.thumb2
                      ValveBiped.Bip01_{}_Finger02 = @.thumb3
                  ValveBiped.Bip01_{}_Finger2 = @.middle1
                    ValveBiped.Bip01_{}_Finger21 = @.middle2
                      ValveBiped.Bip01_{}_Finger22 = @.middle3
  ValveBiped.Bip01_{}_Thigh = @.thigh
    ValveBiped.Bip01_{}_Calf = @.shin
      ValveBiped.Bip01_{}_Foot = @.foot
        ValveBiped.Bip01_{}_Toe0 = @.toes
"""

CHARACTER_CREATOR = """
RL_BoneRoot
  CC_Base_Hip = hips
    CC_Base_Pelvis
      CC_Base_{}_Thigh = @.thigh
        CC_Base_{}_ThighTwist01
        CC_Base_{}_Calf = @.shin
          CC_Base_{}_CalfTwist01
          CC_Base_{}_Foot = @.foot
            CC_Base_{}_ToeBase = @.toes
              CC_Base_{}_BigToe1
    CC_Base_Waist
      CC_Base_Spine01
        CC_Base_Spine02 = chest
          CC_Base_NeckTwist01 = neck
            CC_Base_NeckTwist02
              CC_Base_Head = head
          CC_Base_{}_Clavicle = @.clavicle
            CC_Base_{}_Upperarm = @.upperArm
              CC_Base_{}_UpperarmTwist01
              CC_Base_{}_Forearm = @.foreArm
                CC_Base_{}_ForearmTwist01
                CC_Base_{}_Hand = @.hand
                  CC_Base_{}_Mid1 = @.middle1
                    CC_Base_{}_Mid2 = @.middle2
                      CC_Base_{}_Mid3 = @.middle3
"""

RIGIFY = """
spine = hips
  spine.001
    spine.002
      spine.003 = chest
        spine.004 = neck
          spine.005
            spine.006 = head
        shoulder.{} = @.clavicle
          upper_arm.{} = @.upperArm
            forearm.{} = @.foreArm
              hand.{} = @.hand
                palm.01.{}
                  f_index.01.{} = @.index1
                    f_index.02.{} = @.index2
                      f_index.03.{} = @.index3
                  thumb.01.{} = @.thumb1
                    thumb.02.{} = @.thumb2
                      thumb.03.{} = @.thumb3
                palm.02.{}
                  f_middle.01.{} = @.middle1
                    f_middle.02.{} = @.middle2
                      f_middle.03.{} = @.middle3
  pelvis.{}
  thigh.{} = @.thigh
    shin.{} = @.shin
      foot.{} = @.foot
        toe.{} = @.toes
        heel.02.{}
"""

RIGIFY_DEFORM = """
DEF-spine = hips
  DEF-spine.001
    DEF-spine.002
      DEF-spine.003 = chest
        DEF-spine.004 = neck
          DEF-spine.005
            DEF-spine.006 = head
        DEF-shoulder.{} = @.clavicle
          DEF-upper_arm.{} = @.upperArm
            DEF-upper_arm.{}.001
              DEF-forearm.{} = @.foreArm
                DEF-forearm.{}.001
                  DEF-hand.{} = @.hand
  DEF-pelvis.{}
  DEF-thigh.{} = @.thigh
    DEF-thigh.{}.001
      DEF-shin.{} = @.shin
        DEF-shin.{}.001
          DEF-foot.{} = @.foot
            DEF-toe.{} = @.toes
"""

SMPL = """
Pelvis = hips
  {}_Hip = @.thigh
    {}_Knee = @.shin
      {}_Ankle = @.foot
        {}_Foot = @.toes
  Spine1
    Spine2
      Spine3 = chest
        Neck = neck
          Head = head
        {}_Collar = @.clavicle
          {}_Shoulder = @.upperArm
            {}_Elbow = @.foreArm
              {}_Wrist = @.hand
                {}_Hand
"""

SMPLX = """
pelvis = hips
  {}_hip = @.thigh
    {}_knee = @.shin
      {}_ankle = @.foot
        {}_foot = @.toes
  spine1
    spine2
      spine3 = chest
        neck = neck
          head = head
        {}_collar = @.clavicle
          {}_shoulder = @.upperArm
            {}_elbow = @.foreArm
              {}_wrist = @.hand
                {}_index1 = @.index1
                  {}_index2 = @.index2
                    {}_index3 = @.index3
                {}_thumb1 = @.thumb1
                  {}_thumb2 = @.thumb2
                    {}_thumb3 = @.thumb3
"""

POSER = """
hip = hips
  abdomen
    chest = chest
      neck = neck
        head = head
      {}Collar = @.clavicle
        {}Shldr = @.upperArm
          {}ForeArm = @.foreArm
            {}Hand = @.hand
              {}Thumb1 = @.thumb1
                {}Thumb2 = @.thumb2
                  {}Thumb3 = @.thumb3
              {}Mid1 = @.middle1
                {}Mid2 = @.middle2
                  {}Mid3 = @.middle3
  {}Thigh = @.thigh
    {}Shin = @.shin
      {}Foot = @.foot
        {}Toe = @.toes
"""

GENESIS_8 = """
hip = hips
  pelvis
    {}ThighBend = @.thigh
      {}ThighTwist
        {}Shin = @.shin
          {}Foot = @.foot
            {}Metatarsals
              {}Toe = @.toes
                {}BigToe
  abdomenLower
    abdomenUpper
      chestLower
        chestUpper = chest
          {}Collar = @.clavicle
            {}ShldrBend = @.upperArm
              {}ShldrTwist
                {}ForearmBend = @.foreArm
                  {}ForearmTwist
                    {}Hand = @.hand
                      {}Thumb1 = @.thumb1
                        {}Thumb2 = @.thumb2
                          {}Thumb3 = @.thumb3
                      {}Carpal1
                        {}Index1 = @.index1
                          {}Index2 = @.index2
                            {}Index3 = @.index3
          neckLower = neck
            neckUpper
              head = head
"""

APPLE = """
root
  hips_joint = hips
    {}_upLeg_joint = @.thigh
      {}_leg_joint = @.shin
        {}_foot_joint = @.foot
          {}_toes_joint = @.toes
            {}_toesEnd_joint
    spine_1_joint
      spine_6_joint
        spine_7_joint = chest
          {}_shoulder_1_joint = @.clavicle
            {}_arm_joint = @.upperArm
              {}_forearm_joint = @.foreArm
                {}_hand_joint = @.hand
                  {}_handIndexStart_joint
                    {}_handIndex_1_joint = @.index1
                      {}_handIndex_2_joint = @.index2
                        {}_handIndex_3_joint = @.index3
                          {}_handIndexEnd_joint
          neck_1_joint = neck
            neck_2_joint
              head_joint = head
                jaw_joint
"""

XSENS = """
Pelvis = hips
  {}UpperLeg = @.thigh
    {}LowerLeg = @.shin
      {}Foot = @.foot
        {}Toe = @.toes
  L5
    L3
      T12
        T8 = chest
          Neck = neck
            Head = head
          {}Shoulder = @.clavicle
            {}UpperArm = @.upperArm
              {}ForeArm = @.foreArm
                {}Hand = @.hand
"""

PERCEPTION_NEURON = """
Hips = hips
  {}UpLeg = @.thigh
    {}Leg = @.shin
      {}Foot = @.foot
  Spine
    Spine1
      Spine2
        Spine3 = chest
          Neck = neck
            Head = head
          {}Shoulder = @.clavicle
            {}Arm = @.upperArm
              {}ForeArm = @.foreArm
                {}Hand = @.hand
                  {}HandThumb1 = @.thumb1
                    {}HandThumb2 = @.thumb2
                      {}HandThumb3 = @.thumb3
                  {}InHandIndex
                    {}HandIndex1 = @.index1
                      {}HandIndex2 = @.index2
                        {}HandIndex3 = @.index3
"""

MAKEHUMAN = """
root = hips
  pelvis.{}
    upperleg01.{} = @.thigh
      upperleg02.{}
        lowerleg01.{} = @.shin
          lowerleg02.{}
            foot.{} = @.foot
              toe1-1.{} = @.toes
                toe1-2.{}
              toe2-1.{}
  spine05
    spine04
      spine01 = chest
        neck01 = neck
          neck02
            head = head
        clavicle.{} = @.clavicle
          shoulder01.{}
            upperarm01.{} = @.upperArm
              upperarm02.{}
                lowerarm01.{} = @.foreArm
                  lowerarm02.{}
                    wrist.{} = @.hand
                      finger1-1.{} = @.thumb1
                        finger1-2.{} = @.thumb2
                          finger1-3.{} = @.thumb3
                      metacarpal1.{}
                        finger2-1.{} = @.index1
                          finger2-2.{} = @.index2
                            finger2-3.{} = @.index3
                      metacarpal4.{}
                        finger5-1.{} = @.pinky1
                          finger5-2.{} = @.pinky2
                            finger5-3.{} = @.pinky3
"""

KINECT = """
SpineBase = hips
  SpineMid
    SpineShoulder = chest
      Neck = neck
        Head = head
      Shoulder{} = @.upperArm
        Elbow{} = @.foreArm
          Wrist{} = @.hand
            Hand{}
            Thumb{} = @.thumb1
  Hip{} = @.thigh
    Knee{} = @.shin
      Ankle{} = @.foot
        Foot{} = @.toes
"""

ACCLAIM = """
root = hips
  {}hipjoint
    {}femur = @.thigh
      {}tibia = @.shin
        {}foot = @.foot
          {}toes = @.toes
  lowerback
    upperback
      thorax = chest
        lowerneck = neck
          upperneck
            head = head
        {}clavicle = @.clavicle
          {}humerus = @.upperArm
            {}radius = @.foreArm
              {}wrist = @.hand
                {}hand
                  {}fingers
                {}thumb = @.thumb1
"""

MAYA = """
pelvis_jnt = hips
  {}_leg_jnt = @.thigh
    {}_knee_jnt = @.shin
      {}_ankle_jnt = @.foot
        {}_ball_jnt = @.toes
  spine_jnt = chest
    neck_jnt = neck
      head_jnt = head
    {}_clavicle_jnt = @.clavicle
      {}_arm_jnt = @.upperArm
        {}_elbow_jnt = @.foreArm
          {}_wrist_jnt = @.hand
"""

CONVENTIONS = {
    "HumanIK": ("HumanIK", both_sides(HUMAN_IK, "Character1_Left", "Character1_Right")),
    "Mixamo": ("Mixamo", both_sides(MIXAMO, "mixamorig:Left", "mixamorig:Right")),
    "Unreal": ("Unreal", both_sides(UNREAL, "l", "r")),
    "VRM 1.0": ("VRM", both_sides(VRM, "left", "right")),
    "VRoid": ("VRM", both_sides(VROID, "L", "R")),
    "3ds Max Biped": ("3ds Max Biped", both_sides(BIPED, "L", "R")),
    "Valve": ("Valve", both_sides(VALVE, "L", "R")),
    "Character Creator": ("Character Creator", both_sides(CHARACTER_CREATOR, "L", "R")),
    "Rigify": ("Blender", both_sides(RIGIFY, "L", "R")),
    "Rigify deform": ("Blender", both_sides(RIGIFY_DEFORM, "L", "R")),
    "SMPL": ("SMPL", both_sides(SMPL, "L", "R")),
    "SMPL-X": ("SMPL", both_sides(SMPLX, "left", "right")),
    "Poser": ("Daz", both_sides(POSER, "l", "r")),
    "Genesis 8": ("Daz", both_sides(GENESIS_8, "l", "r")),
    "Apple": ("Apple", both_sides(APPLE, "left", "right")),
    "Xsens": ("Xsens", both_sides(XSENS, "Left", "Right")),
    "Perception Neuron": ("Perception Neuron", both_sides(PERCEPTION_NEURON, "Left", "Right")),
    "MakeHuman": ("MakeHuman", both_sides(MAKEHUMAN, "L", "R")),
    "Kinect": ("SMPL", both_sides(KINECT, "Left", "Right")),
    "Acclaim": ("CMU", both_sides(ACCLAIM, "l", "r")),
    "Maya": ("mixed", both_sides(MAYA, "l", "r")),
}
