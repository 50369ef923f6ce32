------- OpenFAST v5 main file --------------------------------------------------
DTU 10 MW on the upscaled OC4 semisubmersible, parked, JONSWAP sea
---------------------- RUN -----------------------------------------------------
         False   Echo           - write an echo file
       "FATAL"   AbortLevel     - severity that stops the run
          8000   TMax           - length of the run (s)
          0.05   DT             - time step of the solver (s)
             3   ModCoupling    - coupling: 3 = tight, Jacobian renewed when needed
             2   InterpOrder    - order of the input extrapolation
             0   NumCrctn       - extra correction steps (loose coupling)
           1.0   RhoInf         - spectral radius of the integrator at infinite frequency
          1e-4   ConvTol        - tolerance of the coupled iteration
            20   MaxConvIter    - most iterations a step
         99999   DT_UJac        - interval of Jacobian renewal (s)
         1E+06   UJacSclFact    - scaling of loads in the Jacobian
---------------------- MODULES -------------------------------------------------
             1   NRotors        - number of rotors
             1   CompElast      - structure: 1 = ElastoDyn
             0   CompInflow     - wind: 0 = still air, 1 = InflowWind
             0   CompAero       - aerodynamics: 0 = none, 2 = AeroDyn
             0   CompServo      - control: 0 = none
             1   CompSeaSt      - waves: 1 = SeaState
             1   CompHydro      - hydrodynamics: 1 = HydroDyn
             0   CompSub        - flexible substructure: 0 = none
             1   CompMooring    - moorings: 0 = none, 1 = MAP++
             0   CompIce        - ice: 0 = none
             0   CompSoil       - soil: 0 = none
             0   MHK            - marine turbine: 0 = no
             F   MirrorRotor    - rotor turns the other way
---------------------- ENVIRONMENT ---------------------------------------------
       9.80665   Gravity        - gravity (m/s^2)
         1.225   AirDens        - air density (kg/m^3)
          1025   WtrDens        - water density (kg/m^3)
     1.464E-05   KinVisc        - kinematic viscosity (m^2/s)
           335   SpdSound       - speed of sound (m/s)
        103500   Patm           - air pressure (Pa)
          1700   Pvap           - vapour pressure of water (Pa)
           200   WtrDpth        - water depth (m)
             0   MSL2SWL        - still water above mean sea level (m)
---------------------- FILES ---------------------------------------------------
"ElastoDyn.dat"   EDFile         - ElastoDyn
      "unused"   BDBldFile(1)   - BeamDyn, blade 1
      "unused"   BDBldFile(2)   - BeamDyn, blade 2
      "unused"   BDBldFile(3)   - BeamDyn, blade 3
"InflowWind.dat"   InflowFile     - InflowWind
      "unused"   AeroFile       - AeroDyn
      "unused"   ServoFile      - ServoDyn
"SeaState.dat"   SeaStFile      - SeaState
"HydroDyn.dat"   HydroFile      - HydroDyn
      "unused"   SubFile        - SubDyn
     "MAP.dat"   MooringFile    - moorings
      "unused"   IceFile        - ice
      "unused"   SoilFile       - soil
---------------------- OUTPUT --------------------------------------------------
          True   SumPrint       - write a summary file
           500   SttsTime       - interval of progress messages (s)
        999999   ChkptTime      - interval of checkpoints (s)
           0.5   DT_Out         - output time step (s)
             0   TStart         - start of the output (s)
             2   OutFileFmt     - output file: 2 = binary
          True   TabDelim       - tabs between columns of a text output
    "ES15.7E2"   OutFmt         - number format of text output and linearisation
---------------------- LINEARISATION -------------------------------------------
         False   Linearize      - linearise the model
         False   CalcSteady     - search a periodic steady state first
             3   TrimCase       - quantity to trim: 3 = blade pitch
        0.0001   TrimTol        - tolerance of the trim (-)
          0.01   TrimGain       - gain of the trim
             0   Twr_Kdmp       - artificial tower damping during the trim (N s/m)
             0   Bld_Kdmp       - artificial blade damping during the trim (N s/m)
             1   NLinTimes      - number of linearisations
            30   LinTimes       - their times (s)
             2   LinInputs      - inputs: 0 = none, 1 = standard, 2 = all
             1   LinOutputs     - outputs: 1 = the channels listed in the modules
         False   LinOutJac      - add the full Jacobians
         False   LinOutMod      - a file for each module too
---------------------- ANIMATION -----------------------------------------------
             0   WrVTK          - VTK output: 0 = none
             2   VTK_type       - what to draw
         false   VTK_fields     - fields as well
            15   VTK_fps        - frames a second
