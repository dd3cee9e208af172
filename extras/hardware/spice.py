# SPDX-License-Identifier: Apache-2.0
"""A channel, the tile's rail and its switch in ngspice, with the values of circuit.toml.

A driver is a half bridge that breaks before it makes, so what it takes for itself comes on top. What is compared with is closed forms,
`haptogram board power`, and a balance of powers."""
import concurrent.futures
import dataclasses
import json
import math
import subprocess
import tempfile
from pathlib import Path

import netlist
import numpy as np
from table import Row

ELEMENT, DRIVERS = netlist.CIRCUIT["element"], netlist.CIRCUIT["drivers"]
CARRIER = ELEMENT["resonance_hz"]
PERIOD = 1 / CARRIER
VOLTS = float(netlist.PARTS["terminal"]["value"].split()[0])


def value(kind):
    return netlist.number(netlist.PARTS[kind]["value"])


@dataclasses.dataclass(frozen=True)
class Channel:
    """A driver's half with an element. A field that is changed is a variant, or a fault."""

    volts: float = VOLTS
    duty: float = 0.5
    driver: str = netlist.PARTS["driver"]["value"]
    series: float = value("series")
    coupling: float = value("coupling")  # 0: a wire
    bleeder: float = value("bleeder")
    resistance: float = ELEMENT["resistance_ohm"]
    inductance: float = ELEMENT["inductance_h"]
    capacitance: float = ELEMENT["capacitance_f"]
    moved: float = 0.0  # of the resonance, as a share
    longer: float = 0.0  # seconds by which the driver lengthens a pulse
    leak: float = 0.0  # ohm beside the element, which no balance knows

    @property
    def ohm(self):
        return DRIVERS[self.driver]["ohm"]

    @property
    def rise(self):
        return DRIVERS[self.driver]["edge_s"]


def element(n, node, c):
    """Inductance and compliance move together, so losses stay."""
    compliance = 1 / ((2 * math.pi * CARRIER) ** 2 * ELEMENT["inductance_h"]) / (1 + c.moved)
    return (
        f"Cp{n} {node} 0 {c.capacitance:g}\nLm{n} {node} m{n} {c.inductance / (1 + c.moved):g}\n"
        f"Cm{n} m{n} r{n} {compliance:.9g}\nRm{n} r{n} 0 {c.resistance:g}\n"
    )


def half_bridge(n, rail, ohm):
    return (
        f"Bu{n} {rail} o{n} I=(V({rail})-V(o{n}))*(max(0,2*V(c{n})-1)/{ohm:g}+1e-9)\n"
        f"Bd{n} o{n} 0 I=V(o{n})*(max(0,1-2*V(c{n}))/{ohm:g}+1e-9)\n"
    )


def pulses(n, c, delay=0.0):
    return f"Vc{n} c{n} 0 PULSE(0 1 {delay:g} {c.rise:g} {c.rise:g} {c.duty * PERIOD + c.longer - c.rise:.9g} {PERIOD:g})\n"


def wired(n, rail, c, start=0.0):
    """From the driver's supply to the element. The coupling capacitor begins at `start` volts; a mean it would reach after milliseconds."""
    coupling = f"Cs{n} s{n} t{n} {c.coupling:g} IC={start:g}\n" if c.coupling else f"Rc{n} s{n} t{n} 1m\n"
    return half_bridge(n, rail, c.ohm) + f"Rs{n} o{n} s{n} {max(c.series, 1e-3):g}\n" + coupling + element(n, f"t{n}", c)


def channel(c, control=None, start=0.0):
    leak = f"Rleak t1 0 {c.leak:g}\n" if c.leak else ""
    return f"* a channel\nVdd vdd 0 {c.volts:g}\n" + (control or pulses(1, c)) + wired(1, "vdd", c, start) + f"Rb1 t1 0 {c.bleeder:g}\n" + leak


def run(deck, vectors, stop, step, begin=0.0):
    """The solver's own points in time, which follow the edges: a grid would lose part of their charge."""
    with tempfile.TemporaryDirectory() as folder:
        out, deck_file = Path(folder) / "out.txt", Path(folder) / "deck.cir"
        deck_file.write_text(
            deck + ".options reltol=1e-4 abstol=1e-10 method=gear\n.control\nset wr_singlescale\nset numdgt=9\n"
            f"tran {step:g} {stop:g} {begin:g} {step * 4:g} uic\nwrdata {out} {' '.join(vectors)}\nquit\n.endc\n.end\n",
            encoding="utf-8",
        )
        result = subprocess.run(["ngspice", "-b", str(deck_file)], capture_output=True, text=True, timeout=600, check=False)
        if not out.exists():
            raise RuntimeError(f"ngspice made no results:\n{result.stdout[-1500:]}{result.stderr[-1500:]}")
        table = np.loadtxt(out)
    return table[:, 0], dict(zip(vectors, table[:, 1:].T))


def mean(t, x):
    return float(np.trapz(x, t) / (t[-1] - t[0]))


def tone(t, x, hz):
    """Complex amplitude over the whole of t, which must be periods."""
    return 2 * complex(np.trapz(x * np.exp(-2j * np.pi * hz * t), t) / (t[-1] - t[0]))


@dataclasses.dataclass
class Steady:
    """Of eight periods, when all has settled; powers in watts."""

    motion: complex
    supply: float
    driver: float
    series: float
    moving: float
    bleeder: float
    element_vpp: float
    peak: float


def steady(c):
    vectors = ["i(Lm1)", "v(t1)", "v(o1)", "v(s1)", "i(Vdd)"]
    t, x = run(channel(c, start=c.volts * c.duty), vectors, 2.2e-3, 50e-9, 2e-3)
    out = (x["v(o1)"] - x["v(s1)"]) / max(c.series, 1e-3)
    supply = mean(t, -x["i(Vdd)"] * c.volts)
    return Steady(
        motion=tone(t, x["i(Lm1)"], CARRIER),
        supply=supply,
        driver=supply - mean(t, x["v(o1)"] * out),
        series=mean(t, out**2) * c.series,
        moving=mean(t, x["i(Lm1)"] ** 2) * c.resistance,
        bleeder=mean(t, x["v(t1)"] ** 2) / c.bleeder,
        element_vpp=float(np.ptp(x["v(t1)"])),
        peak=float(np.max(np.abs(out))),
    )


def sine_law(c):
    """Worst deviation of the element's current from sin(π duty)."""
    full = abs(steady(c).motion)
    return max(abs(abs(steady(dataclasses.replace(c, duty=d)).motion) / full - math.sin(math.pi * d)) for d in (0.25, 0.1, 0.02))


def over_board_power(c, program):
    """Worst ratio of the supply's power to that of `board power`, which has its numbers by itself."""
    worst = 1.0
    for duty in (0.5, 0.1):
        command = [str(program), "board", "power", netlist.BOARD, "--volts", str(VOLTS), "--duty", str(duty), "--json"]
        told = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
        ratio = steady(dataclasses.replace(c, duty=duty)).supply / (told["motion_w"] + told["charge_w"])
        worst = max(worst, ratio, key=lambda r: abs(math.log(r)))
    return worst


def balance(c):
    s = steady(c)
    return (s.driver + s.series + s.moving + s.bleeder) / s.supply


def rise_over_closed_form(c):
    """Time to 90 % over ln(10) · 2L/R of the element that circuit.toml has."""
    t, x = run(channel(c), ["i(Lm1)"], 2e-3, 100e-9)
    edges = np.arange(80) * PERIOD
    grown = [abs(tone(t[m], x["i(Lm1)"][m], CARRIER)) for m in ((t >= a) & (t <= a + PERIOD) for a in edges)]
    reached = np.interp(0.9 * np.mean(grown[-5:]), grown, edges + PERIOD / 2)
    return reached / (math.log(10) * 2 * ELEMENT["inductance_h"] / ELEMENT["resistance_ohm"])


def spread(c):
    """Worst difference of a detuned element's current from 1 / (1 + i Q (f0/f - f/f0)), by amplitude and phase at once."""
    quality = 2 * math.pi * CARRIER * ELEMENT["inductance_h"] / ELEMENT["resistance_ohm"]
    tuned = steady(Channel()).motion
    worst = 0.0
    for moved in (-0.025, -0.005, 0.005, 0.025):
        found = steady(dataclasses.replace(c, moved=moved)).motion / tuned
        worst = max(worst, abs(found - 1 / (1 + 1j * quality * (1 / (1 + moved) - (1 + moved)))))
    return worst


def stuck(c):
    """Volts over the element 39 ms after its pin went high for ever."""
    _, x = run(channel(c, "Vc1 c1 0 PWL(0 0 1m 0 1.00002m 1)\n"), ["v(t1)"], 40e-3, 2e-6)
    return float(x["v(t1)"][-1])


def modulated(hz):
    """Pulses whose length follows (1 + sin)/2, three periods of it, and the tone that their mean has."""
    count = round(3 / hz / PERIOD)
    duties = np.arcsin((1 + np.sin(2 * np.pi * hz * (np.arange(count) + 0.5) * PERIOD)) / 2) / np.pi
    edge, points = 25e-9, ["0 0"]
    for k, duty in enumerate(duties):
        if duty * PERIOD > 2 * edge:
            a, z = (k + 0.5 - duty / 2) * PERIOD, (k + 0.5 + duty / 2) * PERIOD
            points.append(f"{a:.9g} 0 {a + edge:.9g} 1 {z:.9g} 1 {z + edge:.9g} 0")
    k = np.arange(count)
    return "Vc1 c1 0 PWL(" + "\n+ ".join(points) + ")\n", abs(2 * np.mean(duties * np.exp(-2j * np.pi * hz * (k + 0.5) * PERIOD)))


def audio(c, hz=200.0):
    """Volts at the modulation's frequency over the element."""
    control, _ = modulated(hz)
    t, x = run(channel(c, control), ["v(t1)"], 3 / hz, 200e-9)
    last = t >= 2 / hz
    return abs(tone(t[last], x["v(t1)"][last], hz))


def audio_over_closed_form(c, hz=200.0):
    """Over that of the pulses' mean behind capacitor and bleeder of circuit.toml."""
    turn = 2j * math.pi * hz * value("coupling") * value("bleeder")
    return audio(c, hz) / (VOLTS * modulated(hz)[1] * abs(turn / (1 + turn)))


@dataclasses.dataclass(frozen=True)
class Rail:
    """A hundred channels in ten groups behind one supply; each group has its own inductance to the bulk capacitor."""

    channels: int = 100
    playing: int = 100
    decoupling: float = value("decoupling")
    bulk: float = value("bulk")
    cable_ohm: float = 20e-3
    channel: Channel = Channel()


def rail(r):
    """Of the last group's rail, three periods after all begin in phase: spikes and ripple in volts, and the current of the last channel.

    Ripple is what a mean over 50 ns leaves; spikes are those of a switch's first nanoseconds."""
    deck = [f"* rail\nVsup sup 0 {VOLTS:g}\nRsup sup sa {r.cable_ohm:g}\nLsup sa bus 300n\nRbk bus bk 30m\nLbk bk bl 10n\n"]
    deck.append(f"Cbk bl 0 {r.bulk:g} IC={VOLTS:g}\n")
    per = r.channels // 10
    for g in range(10):
        deck.append(f"Rg{g} bus ga{g} 3m\nLg{g} ga{g} rail{g} 3n\nRd{g} rail{g} da{g} {20e-3 / per:g}\nLd{g} da{g} db{g} {3e-9 / per:g}\n")
        deck.append(f"Cd{g} db{g} 0 {r.decoupling * per / 2:g} IC={VOLTS:g}\n")
    for n in range(r.channels):
        plays = n >= r.channels - r.playing
        deck.append(pulses(n, r.channel, 1e-6) if plays else f"Vc{n} c{n} 0 0\n")
        deck.append(wired(n, f"rail{n // per}", r.channel))
    stop = 130e-6
    t, x = run("".join(deck), ["v(rail9)", f"i(Lm{r.channels - 1})"], stop, 5e-9)
    last = t >= stop - 2 * PERIOD
    volts = x["v(rail9)"][last]
    even = np.interp(np.arange(t[last][0], stop, 1e-9), t[last], volts)
    smooth = np.convolve(even, np.full(50, 1 / 50), "valid")
    return float(np.ptp(volts)), float(np.ptp(smooth)), tone(t[last], x[f"i(Lm{r.channels - 1})"][last], CARRIER)


def among_all(r):
    """A channel's current among all others over its current alone, less 1."""
    return abs(rail(r)[2] / rail(Rail(playing=1))[2] - 1)


@dataclasses.dataclass(frozen=True)
class Switch:
    """The supply's switch; transistors are level-1 models of typical parts."""

    hold: float = value("switch-hold")
    pull: float = value("switch-pull")
    slow: float = value("switch-slow")
    ramp: float = value("switch-ramp")
    pull_down: float = value("pull-down")
    load_ohm: float = VOLTS**2 / 5.6


def switched(s, enable, stop, step, supply=f"{VOLTS:g}"):
    """Drivers' supply and current through the switch; `enable` is a source at the node en."""
    behind = value("decoupling") * 50
    deck = f"""* switch
Vsup fused 0 {supply}
M1 rail gate fs fused power
M2 pull en 0 0 signal
Vs fused fs 0
R1 fused gate {s.hold:g}
C2 fused gate {s.slow:g}
R2 gate pull {s.pull:g}
R3 en 0 {s.pull_down:g}
Cr rail 0 {behind:g} IC=0
Rl rail 0 {s.load_ohm:g}
C3 gate rail {s.ramp:g}
{enable}
.model power PMOS(LEVEL=1 VTO=-1.7 KP=20 RD=5m RS=5m)
.model signal NMOS(LEVEL=1 VTO=1 KP=0.1)
"""
    return run(deck, ["v(rail)", "i(Vs)", "v(en)"], stop, step)


def inrush(s):
    _, x = switched(s, "Ven en 0 PWL(0 0 100u 0 100.1u 5)", 6e-3, 1e-6)
    return float(np.max(x["i(Vs)"]))


def plugged_in(s):
    """Volts that reach the drivers when the supply comes within a microsecond and the enable is low."""
    _, x = switched(s, "Ven en 0 0", 6e-3, 1e-6, supply=f"PWL(0 0 100u 0 101u {VOLTS:g})")
    return float(np.max(x["v(rail)"]))


def off_after(s):
    """Milliseconds from the enable's fall until the drivers' supply is below their least, 4.5 V, while all channels play."""
    t, x = switched(s, "Ven en 0 PWL(0 5 10m 5 10.0001m 0)", 30e-3, 2e-6)
    down = t[(t > 10e-3) & (x["v(rail)"] < 4.5)]
    return (down[0] - 10e-3) * 1e3 if len(down) else math.inf


def supply_before_configuration(s):
    """Volts at the drivers while the FPGA's pull-up gives the enable 128 µA, the most that an iCE40's gives."""
    return float(switched(s, "Iup 0 en 128u", 20e-3, 5e-6)[1]["v(rail)"][-1])


def input_before_configuration(ohm):
    """Volts at a driver's input, likewise; a TTL input takes 0.8 V for low."""
    return float(run(f"* input\nIup 0 in 128u\nRd in 0 {ohm:g}\nCi in 0 20p\n", ["v(in)"], 100e-6, 1e-7)[1]["v(in)"][-1])


def force_of_cheapest(c):
    """The board's own 74HC245 at 5 V through 100 ohms: its share of the tile's force."""
    return abs(steady(c).motion / steady(Channel()).motion) ** 2


CHEAPEST = Channel(driver="74HC245", volts=5.0, series=100.0)


def checks(program):
    """Name, function, what it is given, bounds, the fault in words, and what it is given then."""
    c, r, s = Channel(), Rail(), Switch()
    other = dataclasses.replace
    return [
        ("current against sin(π duty), worst", sine_law, c, 0, 0.01, "pulses 200 ns too long", other(c, longer=200e-9)),
        ("power over that of board power, worst", lambda x: over_board_power(x, program), c, 0.95, 1.03, "an element of 4 nF", other(c, capacitance=4e-9)),
        ("powers of the parts over the supply's", balance, c, 0.97, 1.03, "5 kΩ beside the element", other(c, leak=5e3)),
        ("mW in a driver, both channels", lambda x: 2e3 * steady(x).driver, c, 0, 15, "no series resistor", other(c, series=0.0)),
        ("peak mA of an output", lambda x: 1e3 * steady(x).peak, c, 0, 500, "no series resistor", other(c, series=0.0)),
        ("Vpp over an element at 18 V", lambda x: steady(x).element_vpp, other(c, volts=18.0), 0, ELEMENT["limit_vpp"], "24 V", other(c, volts=24.0)),
        ("rise to 90 % over ln 10 · 2L/R", rise_over_closed_form, c, 0.85, 1.1, "twice the losses", other(c, resistance=1400.0)),
        ("detuned by ± 0.5 and 2.5 %, against closed form", spread, c, 0, 0.08, "losses 1.3 times as high", other(c, resistance=910.0)),
        ("V over an element, pin stuck, after 39 ms", stuck, c, -0.05, 0.05, "no coupling capacitor", other(c, coupling=0.0)),
        ("the same", stuck, c, -0.05, 0.05, "no bleeder", other(c, bleeder=1e9)),
        ("tone of AM at 200 Hz over closed form", audio_over_closed_form, c, 0.9, 1.1, "a bleeder of 4.7 kΩ", other(c, bleeder=4.7e3)),
        ("ripple of the rail, all in phase, mVpp", lambda x: 1e3 * rail(x)[1], r, 0, 300, "100 nF a driver", other(r, decoupling=100e-9)),
        ("spikes on it, mVpp", lambda x: 1e3 * rail(x)[0], r, 0, 700, "UCC27624, no series resistor", other(r, channel=other(c, driver="UCC27624", series=0.0))),
        ("a channel among 100 against alone", among_all, r, 0, 0.01, "2 Ω before it, 1 µF of bulk", other(r, cable_ohm=2.0, bulk=1e-6)),
        ("A of inrush when switched on", inrush, s, 0, 5, "no capacitor to the drain", other(s, ramp=1e-12)),
        ("V at the drivers when plugged in", plugged_in, s, 0, 0.5, "no capacitor to the source", other(s, slow=1e-12)),
        ("ms until drivers are off", off_after, s, 0, 4, "1 MΩ holds the gate", other(s, hold=1e6)),
        ("V at the drivers, FPGA not configured", supply_before_configuration, s, 0, 0.1, "no pull-down at the enable", other(s, pull_down=1e9)),
        ("V at an input, FPGA not configured", input_before_configuration, value("pull-down"), 0, 0.8, "10 kΩ", 10e3),
        ("force of the 74HC245 alone over the tile's", force_of_cheapest, CHEAPEST, 0.11, 0.15, "no series resistor", other(CHEAPEST, series=0.0)),
    ]


def rows(program):
    listed = checks(program)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        right = [pool.submit(function, good) for _, function, good, *_ in listed]
        wrong = [pool.submit(function, bad) for _, function, _, _, _, _, bad in listed]
        return [Row(name, a.result(), low, high, fault, b.result()) for (name, _, _, low, high, fault, _), a, b in zip(listed, right, wrong)]


def variants():
    """What other drivers and supplies give, as a table."""
    tile = abs(steady(Channel()).motion)
    lines = ["| driver, series resistor, supply | force | mW a channel | W for 100 | Vpp over an element | peak mA |", "|---|---|---|---|---|---|"]
    for c in (CHEAPEST, Channel(), Channel(volts=18.0), Channel(driver="UCC27624", volts=18.0)):
        s = steady(c)
        force = (abs(s.motion) / tile) ** 2
        lines.append(f"| {c.driver}, {c.series:g} Ω, {c.volts:g} V | {force:.2f} | {s.supply * 1e3:.1f} | {s.supply * 100:.1f} | {s.element_vpp:.1f} | {s.peak * 1e3:.0f} |")
    return "\n".join(lines) + "\n"


def tones(hz=200.0):
    """What couplings and bleeders leave of the tone that a full modulation of the pulses' length is, and what they cost."""
    lines = ["| capacitor, bleeder | V at 200 Hz over an element | current at 40 kHz | its phase, rad |", "|---|---|---|---|"]
    tile = steady(Channel()).motion
    for farad, ohm in ((0.0, 22e3), (value("coupling"), value("bleeder")), (22e-9, 4.7e3)):
        c = Channel(coupling=farad, bleeder=ohm)
        ratio = steady(c).motion / tile
        phase = math.atan2(ratio.imag, ratio.real)
        lines.append(f"| {f'{farad * 1e9:g} nF' if farad else 'none'}, {ohm / 1e3:g} kΩ | {audio(c, hz):.2f} | {abs(ratio):.2f} | {phase:+.2f} |")
    return "\n".join(lines) + "\n"
