"""Files in the layouts of instruments and programs, with made numbers.

    python3 make_layouts.py

writes them beside itself. The numbers obey five laws, which tests/suite/identify/layouts.rs checks in SI units:
relaxation 1000 t^-0.2 Pa, creep 0.001 t^0.2 1/Pa, sweep |G*| = 5000 w^0.25 Pa at 22.5 degrees,
press depth 1e-6 t m and force 16/9 sqrt(25e-6) 1000 depth^1.5 N, slab position 1e-3 t m and force 500 position N.
"""

import math
import pathlib

HERE = pathlib.Path(__file__).parent
RAD = math.radians(22.5)


def write(name, text, encoding="utf-8"):
    (HERE / name).write_bytes(text.encode(encoding))


def g(x):
    return f"{x:.6g}"


def table(columns, sep="\t", comma=False, quote=False, first=""):
    lines = []
    for row in zip(*columns):
        cells = [cell if isinstance(cell, str) else g(cell) for cell in row]
        if comma:
            cells = [cell.replace(".", ",") for cell in cells]
        if quote:
            cells = [f'"{cell}"' for cell in cells]
        lines.append(first + sep.join(cells))
    return "\n".join(lines) + "\n"


T = [0.01 * 1.6**k for k in range(12)]
RELAX = [1000 * t**-0.2 for t in T]
CREEP = [0.001 * t**0.2 for t in T]
W = [0.1 * 10 ** (k / 4) for k in range(12)]
ABS = [5000 * w**0.25 for w in W]
ST = [m * math.cos(RAD) for m in ABS]
LO = [m * math.sin(RAD) for m in ABS]
HZ = [w / (2 * math.pi) for w in W]
S = [0.5 * k for k in range(12)]
DEPTH = [1e-6 * s for s in S]
PRESS = [16 / 9 * math.sqrt(25e-6) * 1000 * d**1.5 for d in DEPTH]
POS = [1e-3 * s for s in S]
FORCE = [500 * x for x in POS]


def times(values, factor):
    return [v * factor for v in values]


def same(value, n=12):
    return [value] * n


def count(n=12):
    return [str(k + 1) for k in range(n)]


# TA Instruments TRIOS, ARES-G2, DMA 850, Q800, ARES with Orchestrator.
PRE = "Filename\trun 1\nInstrument name\t5332-0001\nOperator\tanon\nrundate\t02/03/2026\nSample name\tG\n[Geometry Parameters]\nDiameter\t40.0 mm\nGap\t1000.0 µm\nCompliance\t0.70 mrad/N.m\nStress constant\t79577.5 Pa/N.m\n"
write("trios-relaxation.txt", PRE + "[step]\nStress relaxation - 1\nStep time\tTemperature\tRelaxation modulus\tTime\tStress\tStress (step)\ns\t°C\tPa\tmin\tPa\tPa\n"
      + table([T, same(25.01), RELAX, [(t + 30) / 60 for t in T], times(RELAX, 0.01), times(RELAX, 0.01)]))
write("trios-sweep.txt", PRE + "[Step]\nStep name\tFrequency sweep (25.0 °C)\nNumber of points\t12\nVariables\tRun time\tTemperature\tAngular frequency\tStorage modulus\tLoss modulus\tTan(delta)\tComplex viscosity\tFrequency\tShear rate\nUnits\ts\t°C\trad/s\tMPa\tMPa\t\tPa.s\tHz\t1/s\n"
      + table([S, same(25.0), W, times(ST, 1e-6), times(LO, 1e-6), same(math.tan(RAD)), [a / w for a, w in zip(ABS, W)], HZ, W], first="Data point\t"))
write("trios-creep.csv", "Filename,run 2\nOperator,anon\nGap,1000 µm\n\n[step]\nCreep - 1\nStep time,Compliance,Strain,Temperature\ns,1/MPa,%,°C\n"
      + table([T, times(CREEP, 1e6), times(CREEP, 100), same(20.0)], ","))
write("dma850-sweep.csv", "Version,1\nProcedure,Frequency sweep\nTemperature,Frequency,Storage modulus,Loss modulus,Tan(delta),Static force\n°C,Hz,MPa,MPa,,N\n"
      + table([same(35.0), HZ, times(ST, 1e-6), times(LO, 1e-6), same(math.tan(RAD)), same(0.01)], ","))
write("q800-relaxation.txt", "CLOSED\t10\nVersion\t1.00\nRunSerial\t7\nInstrument\tDMA Q800\nNsig\t3\nSig1\tTime (min)\nSig2\tTemperature (°C)\nSig3\tRelaxation Modulus (MPa)\nDate\t02-Mar-26\nStartOfData\n"
      + table([times(T, 1 / 60), same(25.0), times(RELAX, 1e-6)], " "))
write("ares-orchestrator.txt", "Test Name: sweep\nDate: 2/3/2026\n\nFreq\tG'\tG\"\ttan_delta\tTemp\nrad/s\tdyn/cm²\tdyn/cm²\t\t°C\n"
      + table([W, times(ST, 10), times(LO, 10), same(math.tan(RAD)), same(25.0)]))

# Anton Paar RheoCompass and Rheoplus.
write("rheocompass-sweep.csv", "Project:\tgels\nTest:\tsweep\n\nResult:\tgel 1\n\nInterval and data points:\t1\t12\n\nInterval data:\tPoint No.\tAngular Frequency\tStorage Modulus\tLoss Modulus\tStatus\n\t\t\t\t\t\n\t\t[rad/s]\t[Pa]\t[Pa]\t\n".replace("\n", "\r\n")
      + table([count(), W, ST, LO, same("ME-")], comma=True, first="\t").replace("\n", "\r\n"), "utf-16")
write("rheocompass-german.csv", "Projekt:\tGele\nErgebnis:\tGel 2\nAbschnitt und Messpunkte:\t1\t12\n\nAbschnittsdaten:\tPunkt\tZeit\tRelaxationsmodul\tSchubspannung\tScherdeformation\n\t\t[s]\t[kPa]\t[Pa]\t[%]\n"
      + table([count(), T, times(RELAX, 1e-3), times(RELAX, 0.01), same(1.0)], comma=True, first="\t"), "utf-16")
write("rheoplus-sweep.txt", "Data Series Information\nName:\tgel 1\nSample:\tG\nNumber of Intervals:\t1\nApplication:\tRHEOPLUS/32\n\nMeas. Pts.\tAngular Frequency\tStorage Modulus\tLoss Modulus\tDamping Factor\tTorque\tStatus\n\t[1/s]\t[Pa]\t[Pa]\t[1]\t[µNm]\t\n"
      + table([count(), W, ST, LO, same(math.tan(RAD)), times(ABS, 1e-3), same("TGC,Dy_")]), "latin-1")
write("rheoplus-creep.txt", "Name:\tgel 1\nInterval:\t1\nNumber of Data Points:\t12\nMeas. Pts.\tTime\tStrain\tCreep Compliance\tStatus\n\t[s]\t[%]\t[1/Pa]\t\n"
      + table([count(), T, times(CREEP, 1000), CREEP, same("")]))

# Thermo Haake RheoWin.
write("rheowin-sweep.csv", "HAAKE RheoWin 4.87.0001;;;;;;\nSample;gel;;;;;\nf in Hz;ω in rad/s;G' in Pa;G\" in Pa;|G*| in Pa;δ in °;T in °C\n"
      + table([HZ, W, ST, LO, ABS, same(22.5), same(20.0)], ";", True))
write("rheowin-creep.txt", "t in s\tt_seg in s\tJ in 1/Pa\tγ in -\tτ in Pa\tT in °C\n"
      + table([[t + 60 for t in T], T, CREEP, times(CREEP, 10), same(10.0), same(20.0)]))

# Malvern Kinexus rSpace and Bohlin.
write("kinexus-sweep.csv", "Action Name,Frequency(Hz),Shear modulus (elastic component)(Pa),Shear modulus (viscous component)(Pa),Phase angle(°),Temperature(°C)\n"
      + table([same("Frequency table"), HZ, ST, LO, same(22.5), same(25.0)], ","))
write("kinexus-complex.csv", "Sample Name,Gel 1\nDate,02/03/2026 10:00\n\nAction Name,Frequency(Hz),Complex modulus(Pa),Phase angle(°),Temperature(°C)\n"
      + table([same("Frequency table"), HZ, ABS, same(22.5), same(25.0)], ","))
write("bohlin-sweep.txt", "Bohlin Gemini\nGeometry: CP 4/40\n\nTime (s)\tFrequency (Hz)\tPhase Angle (°)\tComplex Modulus (Pa)\tElastic Modulus (Pa)\tViscous Modulus (Pa)\n"
      + table([S, HZ, same(22.5), ABS, ST, LO]), "latin-1")

# Optics11 Piuma and Chiaro.
OPTICS = "Date\t02/03/2026\tTime\t10:00:00\tStatus\tOK\nX-position (um)\t10.5\nTip radius (um)\t25.0\nk (N/m)\t0.5\nSoftware version:\t3.2\n\n"
write("piuma.txt", OPTICS + "Time (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\tAuxiliary\n"
      + table([S, times(PRESS, 1e6), times(DEPTH, 1e9), times(PRESS, 2e9), times(DEPTH, 2e9), same(0.0)]))
write("chiaro.txt", OPTICS.replace("\n\n", "\nControl mode:\tIndentation\nE[eff] (Pa)\t1333\n\n") + "Time (s)\tLoad (nN)\tIndentation (µm)\tPiezo (nm)\n"
      + table([S, times(PRESS, 1e9), times(DEPTH, 1e6), times(DEPTH, 2e9)]))

# Atomic force microscopes and nanoindenters.
write("afm-workshop.csv", "Force-Distance Curve\nFile Format:\t3\n\nDate:\tMonday, March 2, 2026\nTime:\t1:41:26 PM\nMode:\tSingle\nPoint:\t1\nX, um:\t25.0\nY, um:\t40.0\n\nExtend Z-Sense(nm),Extend Force(nN),Retract Z-Sense(nm),Retract Force(nN)\n"
      + table([times(DEPTH, 1e9), times(PRESS, 1e9), times(DEPTH, 1e9), times(PRESS, 1e9)], ","))
write("nt-mdt.txt", table([times(DEPTH, 1e9), times(PRESS, 1e9), times(PRESS, 1e9)], comma=True))
write("jpk.txt", "# exportVersion: 2\n# sensitivity: 6.2e-8 m/V\n# springConstant: 0.05\n#\n# fancyNames: \"Height (measured)\" \"Vertical deflection\" \"Series Time\"\n# columns: measuredHeight vDeflection seriesTime\n# units: m N s\n"
      + table([DEPTH, PRESS, S], " "))
write("hysitron.txt", "Hysitron TI 950\nNumber of Points = 12\n\nDepth (nm)\tLoad (µN)\tTime (s)\tDepth (V)\tLoad (V)\n"
      + table([times(DEPTH, 1e9), times(PRESS, 1e6), S, times(S, 0.1), times(S, 0.2)]), "latin-1")
write("softmech.csv", "Z(m),F_avg(N),F_std(N)\n" + table([DEPTH, PRESS, times(PRESS, 0.01)], ","))

# Testing machines.
write("mach1.txt", "<Mach-1 File>\n<INFO>\nTime:\t10:00:00\nDate:\t02/03/2026\nLoad Cell:\t1.5 N\n<END INFO>\n<Stress Relaxation>\nRamp Amplitude, mm:\t0.5\n<DATA>\nTime, s\tPosition (z), mm\tFz, gf\n"
      + table([S, times(POS, 1e3), times(FORCE, 1 / 9.80665e-3)]) + "<END DATA>\n")
write("mach1-two.txt", "<INFO>\nTime:\t10:00:00\n<END INFO>\n" + "".join(
      f"<Move Relative, step {n}>\n<DATA>\nTime, s\tPosition (z), mm\tFz, gf\n" + table([S, times(POS, 1e3), times(FORCE, f / 9.80665e-3)]) + "<END DATA>\n"
      for n, f in [(1, 2.0), (2, 1.0)]))
write("bluehill.csv", "\"Time\",\"Compressive extension\",\"Compressive load\"\n\"(s)\",\"(mm)\",\"(N)\"\n"
      + table([S, times(POS, 1e3), FORCE], ",", quote=True))
write("bluehill-raw.csv", "Results Table 1\n,Maximum load,Modulus\n,(N),(MPa)\n1,2.75,0.5\n\nTime (s),Compressive extension (mm),Compressive load (N),Compressive strain (Extension) (%)\n"
      + table([S, times(POS, 1e3), FORCE, times(POS, 5e3)], ","))
write("bluehill-german.csv", "Zeit;Weg;Kraft\n(s);(mm);(N)\n" + table([S, times(POS, 1e3), FORCE], ";", True))
write("bluehill-thousands.csv", "Time,Extension,Load\n(s),(mm),(mN)\n" + "".join(f'"{s:g}","{1e3 * x:.2f}","{1e3 * f:,.1f}"\n' for s, x, f in zip(S, POS, FORCE)))
write("testxpert-german.txt", "Prüfer;anon\nProbe: 3, Höhe 20 mm\nPrüfzeit;Standardweg;Standardkraft\ns;mm;N\n"
      + table([S, times(POS, 1e3), FORCE], ";", True), "latin-1")
write("testxpert.txt", "Specimen 1\nTest time\tStandard travel\tStandard force\ns\tµm\tN\n" + table([S, times(POS, 1e6), FORCE]))
write("mts793.dat", "MTS793|BTW|ENU|1|2|.|/|:|1|0|0|A\n\nData Acquisition: Timed\nStation Name: rig.cfg\nTime\tAxial Displacement\tAxial Force\nSec\tmm\tkN\n"
      + table([S, times(POS, 1e3), times(FORCE, 1e-3)]))
write("mts-testworks.csv", "\"Crosshead (mm)\",\"Load (N)\",\"Time (s)\"\n" + table([times(POS, 1e3), FORCE, S], ","))
write("testresources.csv", "TestResources XY\nTest Date: 3/2/2026\nPoint,Elapsed Time,Force,Position\n(#),(sec),(kgf),(mm)\n"
      + table([count(), S, times(FORCE, 1 / 9.80665), times(POS, 1e3)], ","))
write("electroforce.txt", "Bose ElectroForce\n\nElapsed Time (sec)   Disp (mm)   Load (N)\n"
      + "".join(f"{s:14.3f} {1e3 * x:14.5f} {f:14.5f}\n" for s, x, f in zip(S, POS, FORCE)))
write("cellscale.csv", "SetName,Cycle,Time_S,Size_mm,Displacement_mm,Force_mN\n"
      + table([same("Compress"), same("1-Compress"), S, same(10.0), times(POS, 1e3), times(FORCE, 1e3)], ","))
write("texture-analyser.csv", "Force,Distance,Time\ng,mm,sec\n" + table([times(FORCE, 1 / 9.80665e-3), times(POS, 1e3), S], ","))
write("netzsch-dma.txt", "#EXPORTTYPE:DATA ALL\n#INSTRUMENT:NETZSCH DMA 242\n#DATE:02.03.2026\n##Temp./°C;Time/min;f/Hz;E'/MPa;E''/MPa;tan d\n"
      + table([same(25.0), S, HZ, times(ST, 1e-6), times(LO, 1e-6), same(math.tan(RAD))], ";", True), "latin-1")
write("labview.lvm", "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDate\t2026/03/02\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t12\t12\t\n***End_of_Header***\t\t\t\nX_Value\tForce (N)\tDisplacement (mm)\tComment\n"
      + table([S, FORCE, times(POS, 1e3)]))

# Programs.
write("rheos-sweep.csv", table([W, ST, LO], ","))
write("pyvisco-sweep.csv", "\ufefff,E_stor,E_loss,T,Set\nHz, MPa, MPa, C, -\n" + table([HZ, times(ST, 1e-6), times(LO, 1e-6), same(25.3), same("0")], ","))
write("pyvisco-sets.csv", "t,E_relax,T,Set\ns,MPa,°C,-\n" + table([T[::-1], times(RELAX[::-1], 1e-6), same(25.3), same("0")], ",")
      + table([T[::-1], times(RELAX[::-1], 2e-6), same(18.1), same("1")], ","))
write("rheojax.csv", "Time\tRelaxation Modulus\n" + table([T, RELAX]))
write("origin.txt", "Angular frequency\tStorage\tLoss\nrad/s\tkPa\tkPa\n\tgel, day 3\tgel, day 3\n" + table([W, times(ST, 1e-3), times(LO, 1e-3)]))
write("spreadsheet.csv", "my gel;;;\n;;;\nFrequency [Hz];Storage modulus [Pa];Loss modulus [Pa];\n" + "".join(
      f"{h:.6f};{s:,.2f};{l:,.2f};\n".replace(",", " ").replace(".", ",") for h, s, l in zip(HZ, ST, LO)) + ";;;\n")
write("numbers-minus.csv", "time_s,position_mm,force_N\n" + "".join(f"{s:g},{1e3 * x:g},{f:g}\n" for s, x, f in zip(S, POS, FORCE)).replace("-", "\u2212"))

# Other languages and locales, rows without numbers, several steps in one table.
ROWS = list(zip(S, times(POS, 1e3), times(FORCE, 1e3)))


def rows(number, sep):
    return "".join(sep.join(number(cell) for cell in row) + "\n" for row in ROWS)


def grouped(thousands, decimals):
    return lambda x: f"{x:,.2f}".replace(",", "T").replace(".", decimals).replace("T", thousands)


write("testxpert-french.txt", '"Épaisseur éprouvette",1,"mm"\n"Date/heure",43173.4,""\n"Opérateur",""\n"Temps","Traverse absolue","Force standard","Course standard"\n"s","mm","N","mm"\n'
      + table([S, times(POS, 5e3), FORCE, times(POS, 1e3)], ","), "latin-1")
write("spreadsheet-turkish.csv", "Süre [s];Yer değiştirme [mm];Kuvvet [mN]\n" + rows(grouped(".", ","), ";"))
write("spreadsheet-capitals.csv", "SÜRE (s);DEPLASMAN (mm);KUVVET (mN)\n" + rows(grouped(".", ","), ";"))
write("spreadsheet-french.csv", "Temps (s);Déplacement (mm);Force (mN)\n" + rows(grouped("\u202f", ","), ";"))
write("bluehill-unquoted.csv", "Time (s),Extension (mm),Load (mN)\n" + rows(grouped(",", "."), ","))
write("kinexus-actions.csv", "Action Name;Time (sequence)(s);Time (action)(s);Shear stress(Pa);Shear relaxation modulus(Pa)\n"
      + table([same("Pre Shear"), T, T, same(1.0), same("")], ";", True)
      + table([same("Relax"), [t + 100 for t in T], T, times(RELAX, 0.01), RELAX], ";", True))
SWEPT = table([count(), S, HZ, ST, LO], comma=True, first="\t").split("\n")
write("rheocompass-french.csv", "Projet:\tgels\n\nIntervalle et points de données:\t1\t14\n\nInterval données:\tPoint No.\tIntervalle Temps\tFréquence\tModule de Stockage\tModule de Perte\n\t\t\t\tSinusoïdes\tSinusoïdes\n\t\t[s]\t[Hz]\t[Pa]\t[Pa]\n"
      + "\n".join(["\t1  (invalide)\t\t\t\t", *SWEPT[:5], "\t7  (invalide)\t\t\t\t", *SWEPT[5:]]), "utf-16")
with (HERE / "rheocompass-french.csv").open("ab") as file:
    file.write(b"\n")
write("rheowin-elements.txt", "C:\\gel.rwd\nDate / Time / Version: 02.03.2026 / 10:00:00 / HAAKE RheoWin 4.30\n\n;t / s;t_seg / s;omega / rad/s;G' / Pa;G'' / Pa;\n"
      + table([[f"1|{k}" for k in count()], S, S, same(6.283), same(1000.0), same(100.0), same("")], ";", True)
      + table([[f"2|{k}" for k in count()], [s + 6 for s in S], S, W, ST, LO, same("")], ";", True))
