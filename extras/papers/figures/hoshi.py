# SPDX-License-Identifier: Apache-2.0
"""Figures of the paper Hoshi."""

import numpy as np

from .work import crossings, first, legend, panels, row, save, width


def hoshi_3(work, name):
    found = work.computed["energy_loss"]
    figure, (panel,) = panels(1, (8.5, 4.2))
    panel.plot(found["khz"], 100 * np.array(found["hoshi"]), label="as the paper: 1 dB/m at 40 kHz, rising as f²")
    panel.plot(found["khz"], 100 * np.array(found["iso_9613_1"]), "--", label="ISO 9613-1: 20 °C, 50 % humidity")
    panel.set(xlabel="frequency / kHz", ylabel="energy lost on 200 mm / %", title="Loss of energy in 200 mm of air", xlim=(0, 200), ylim=(0, 75))
    panel.grid(alpha=0.3)
    legend(panel, loc="upper left")
    save(work, figure, name)
    return [
        row("absorption at 40 kHz", found["absorption_40_khz_np_m"], "Np/m", 0.115, "text"),
        row("energy lost on 200 mm at 40 kHz", 100 * found["lost_40_khz"], "%", 4.0, "theory", "the paper rounds, or cuts off"),
        row("the same at 160 kHz", 100 * found["lost_160_khz"], "%", 50.0, "theory", "a round number in the paper"),
        row("radiation pressure kept on 400 mm at 40 kHz: more than", 100 * found["kept_at_400_mm"], "%", 90.0, "theory", "a bound in the paper: more than 90 %"),
        row("by ISO 9613-1: absorption at 40 kHz", found["iso_absorption_40_khz_np_m"], "Np/m", 0.115, "text", "20 °C, 50 % relative humidity; the paper's value has another source"),
        row("by ISO 9613-1: energy lost at 40 kHz", 100 * found["iso_lost_40_khz"], "%", 4.0, "theory"),
        row("by ISO 9613-1: energy lost at 160 kHz", 100 * found["iso_lost_160_khz"], "%", 50.0, "theory", "molecular relaxation flattens the rise; f² overstates it"),
    ]  # fmt: skip


def hoshi_row(work, name):
    """The closed forms of section 2.2, drawn as what the force is made of."""
    found = work.computed["hoshi_focus"]
    figure, (panel,) = panels(1, (8.5, 4.2))
    labels = ["theory: eq. 4 and 5", "exact spherical waves", "with the T4010A1's directivity", "and phases in 16 steps", "paper, measured"]
    values = [found["force_mn"], found["force_spherical_mn"], found["force_pattern_mn"], found["force_16_steps_mn"], 16.0]
    bars = panel.barh(labels[::-1], values[::-1], color=["#c0392b"] + ["#174a7c"] * 4)
    panel.bar_label(bars, fmt="%.1f mN", padding=4, fontsize=9)
    panel.set(xlabel="force through the focal square / mN", xlim=(0, 185), title="18 × 18 elements of 36 Pa rms at 200 mm, focus at 200 mm")
    panel.axvline(143, color="#666666", lw=0.8, ls=":")
    save(work, figure, name)
    taken, missing = 1 - found["force_16_steps_mn"] / found["force_spherical_mn"], 1 - 16.0 / found["force_16_steps_mn"]
    why = (
        "the paper's own list: decay and directivity per transducer, angles of incidence, unequal delays, 16 phase steps, mutual "
        f"impedance, non-linear air. Directivity and steps, computed here, take {taken:.0%} away; {missing:.0%} are missing"
    )
    return [
        row("focal diameter w_f", found["w_f_mm"], "mm", 19.0, "theory", "the paper rounds"),
        row("focal depth w_d", found["w_d_mm"], "mm", 42.0, "theory"),
        row("first side lobe over the peak (eq. 4)", found["side_lobe"], "", 0.05, "theory", "the paper says about 0.05"),
        row("force (eq. 5 on eq. 4)", found["force_mn"], "mN", 143.0, "theory"),
        row("force, spherical waves without the Fresnel approximation", found["force_spherical_mn"], "mN", 143.0, "theory", "each element's 36 Pa is at 200 mm on its axis"),
        row("the same with the T4010A1's directivity", found["force_pattern_mn"], "mN", 143.0, "theory"),
        row("and with phases in 16 steps", found["force_16_steps_mn"], "mN", 16.0, "measured", why),
        row("level of one transducer, 24 Pa rms", found["one_level_db"], "dB", 121.5, "text", "24 Pa rms is 121.58 dB"),
        row("radiation pressure of 100 in phase at 300 mm", found["hundred_radiation_pa"], "Pa", 83.0, "theory"),
    ]  # fmt: skip


def hoshi_6(work, name):
    found = work.computed["hoshi_focus"]
    x, cut = np.array(found["eq4_x_mm"]), np.array(found["eq4_radiation"])
    coarse = slice(None, None, 10)
    u, exact = work.line("x@y=0,z=200", "--focus", "0,0,200", "--array", work.hoshi_of_points, "--extent", 45, "--step", 0.1)
    exact = exact / exact.max()
    figure, axes = panels(2, (11.5, 4.9))
    drawn = axes[0].pcolormesh(x[coarse], x[coarse], np.outer(cut[coarse], cut[coarse]), cmap="magma", vmin=0, vmax=1, shading="nearest", rasterized=True)
    axes[0].set(xlabel="x / mm", ylabel="y / mm", aspect="equal", title="eq. 4, focal plane at 200 mm")
    figure.colorbar(drawn, ax=axes[0], label="radiation pressure over its peak", shrink=0.85)
    axes[1].plot(x, cut, label="eq. 4 (Fresnel)")
    axes[1].plot(u, exact, "--", label="exact spherical waves")
    axes[1].axhline(0.05, color="#666666", lw=0.8, ls=":", label="paper: side lobes about 0.05")
    axes[1].set(xlabel="x / mm", ylabel="radiation pressure over its peak", title="along x through the focus")
    axes[1].grid(alpha=0.3)
    legend(axes[1])
    save(work, figure, name)
    near = (abs(u) > found["w_f_mm"] / 2) & (abs(u) < 1.2 * found["w_f_mm"])
    zeros = x[1:-1][(cut[1:-1] < cut[:-2]) & (cut[1:-1] < cut[2:])]
    return [
        row("side lobe, eq. 4", found["side_lobe"], "", 0.05, "theory", "the paper says about 0.05"),
        row("side lobe, exact spherical waves", exact[near].max(), "", 0.05, "theory", "eq. 4 takes distances to second order, and equal amplitudes"),
        row("diameter between the zeros, eq. 4", zeros[zeros > 0].min() - zeros[zeros < 0].max(), "mm", 19.0, "theory"),
    ]


def hoshi_11(work, name):
    source = ("--focus", "0,0,200", "--array", "hoshi-18x18")
    x, across = work.line("x@y=0,z=200", *source, "--extent", 50, "--step", 0.1)
    z, along = work.line("z@x=0,y=0", *source, "--z", "60:400", "--step", 0.5)
    across, along = across / across.max(), along / along[int(np.argmin(abs(z - 200)))]
    figure, axes = panels(2, (11.5, 4.4))
    axes[0].plot(x, across)
    axes[0].set(xlabel="x / mm", ylabel="radiation pressure over that at the focus", title="(b) along x, y = 0, z = 200 mm")
    axes[1].plot(z, along)
    axes[1].axhline(0.2, color="#c0392b", lw=0.8, ls="--", label="the paper's threshold, 0.2")
    axes[1].set(xlabel="z / mm", ylabel="radiation pressure over that at the focus", title="(c) along z, x = y = 0")
    legend(axes[1])
    for axis in axes:
        axis.grid(alpha=0.3)
    save(work, figure, name)
    minima = x[1:-1][(across[1:-1] < across[:-2]) & (across[1:-1] <= across[2:])]
    low, high = crossings(z, along, 0.2, int(np.argmax(along)))
    lobes = across[(abs(x) > 9.5) & (abs(x) < 28)]
    closed = work.computed["hoshi_focus"]["w_d_mm"]
    return [
        row("diameter, between the minima along x", minima[minima > 0].min() - minima[minima < 0].max(), "mm", 20.0, "measured"),
        row("width at half maximum along x", width(x, across), "mm"),
        row("first side lobe along x", lobes.max(), "", 0.05, "theory", "the paper's measured lobes are not symmetric; its text gives no number for them"),
        row("depth at a threshold of 0.2", high - low, "mm", 100.0, "measured", "about 100 mm in the paper, which compares it with w_d, another measure"),
        row("the same over w_d", (high - low) / closed, "", 2.4, "measured"),
        row("where along z it is largest", z[int(np.argmax(along))], "mm", why="a focused field's maximum lies nearer to the array than its focal point"),
    ]  # fmt: skip


def hoshi_12(work, name):
    found = work.computed["modulation"]
    step = found["step_us"] / 1e3
    envelope, wave = np.array(found["envelope_pa"]), np.array(found["pressure_pa"])
    half = 10
    t = np.arange(len(envelope)) * step - found["second_order"]["first_arrival_us"] / 1e3
    inner = slice(half, len(t) - half)
    t, envelope, wave = t[inner], envelope[inner], wave[inner]
    full = envelope.max()
    radiation = (envelope / full) ** 2
    figure, axes = panels(2, (11.5, 4.4))
    for axis, limits in zip(axes, ((-0.5, 9.2), (0, 1))):
        axis.plot(t, wave / full, lw=0.4, color="#9ab8d6", label="ultrasound")
        axis.plot(t, envelope / full, color="#174a7c", lw=1, label="its envelope")
        axis.plot(t, radiation, color="#c0392b", label="radiation pressure")
        axis.set(xlabel="time after the first arrival / ms", ylabel="over its maximum", xlim=limits, ylim=(-1.1, 1.1))
        axis.grid(alpha=0.3)
    axes[0].set_title("(a) 100 Hz modulation, at the focus, 200 mm")
    axes[1].set_title("(b) the first millisecond")
    legend(axes[1], loc="lower right")
    save(work, figure, name)
    rise = first(t, envelope / full, 0.9)
    stop = 5.0
    after = t > stop
    fall = first(t[after], -(envelope / full)[after], -0.1) - stop
    radiation_rise = first(t, radiation, 0.9)
    radiation_fall = first(t[after], -radiation[after], -0.1) - stop
    reached = float(np.interp(0.5, t, envelope / full))
    why = "ours is the pressure itself; in the paper's it went through a sensor, whose filters were compensated"
    return [
        row("rise of the ultrasound to 90 %", rise, "ms", 0.5, "measured", "the paper does not say to which level"),
        row("amplitude 0.5 ms after the first arrival", 100 * reached, "%"),
        row("fall of the ultrasound to 10 %", fall, "ms", 0.5, "measured"),
        row("rise of the radiation pressure to 90 %", radiation_rise, "ms", 1.0, "measured", "the paper says nearly 1 ms; " + why),
        row("fall of the radiation pressure to 10 %", radiation_fall, "ms", 1.0, "measured", "the square falls faster than the amplitude; " + why),
    ]  # fmt: skip


def hoshi_7(work, name):
    """Section 3.1 and eq. 7: pulses on 16 segments."""
    found = work.computed["quantised"]
    figure, axes = panels(2, (11.5, 4.6))
    for place, element in enumerate(found["row"]):
        level = len(found["row"]) - 1 - place
        segment = np.arange(33)
        high = (segment - element["start"]) % 16 < element["length"]
        axes[0].step(segment, 0.7 * high + level, where="post", color="#174a7c", lw=1.3)
        for cycle in (0, 1):
            axes[0].plot([element["exact_start"] + 16 * cycle], [level - 0.08], "^", color="#c0392b", ms=4, label="exact start" if place + cycle == 0 else None)
    axes[0].set(xlabel="time / segments of 1.5625 µs", ylabel="element of the row y = 5 mm", xlim=(0, 32), xticks=range(0, 33, 4),
                yticks=[len(found["row"]) - 1 - i + 0.35 for i in range(len(found["row"]))],
                yticklabels=[f"x = {e['x_mm']:.0f} mm" for e in found["row"]], ylim=(-1.3, 9), title="focus at (0, 0, 200) mm: phases in 16 steps")  # fmt: skip
    axes[0].grid(axis="x", alpha=0.3)
    legend(axes[0], loc="lower right")
    duty = np.linspace(0, 1, 401)
    axes[1].plot(duty, np.sin(np.pi * duty), color="#174a7c", label="pressure, eq. 7: |sin(πD/T)|")
    axes[1].plot(duty, np.sin(np.pi * duty) ** 2, "--", color="#c0392b", label="radiation pressure: its square")
    steps = np.arange(9) / 16
    axes[1].plot(steps, found["carrier"], "o", color="#174a7c", label="pulses of 0 to 8 segments: their 40 kHz")
    axes[1].plot(steps, np.array(found["carrier"]) ** 2, "s", color="#c0392b", ms=5)
    axes[1].set(xlabel="pulse width over the period, D/T", ylabel="over its maximum", title="amplitudes of the carrier", xlim=(0, 1), ylim=(0, 1.05))
    axes[1].grid(alpha=0.3)
    legend(axes[1], loc="lower center")
    save(work, figure, name)
    table = np.sin(np.pi * np.arange(9) / 16)
    return [
        row("clocks of 25.6 MHz in a segment", 25.6e6 / 40e3 / 16, "", why="a segment of 1.5625 µs, exactly"),
        row("amplitudes of pulses of 0 to 8 segments: how many different", len(set(np.round(found["drive"], 9))), "", 8, "text",
            "three bits name eight; silence, or another one of the nine, must be left out, and the paper does not say which"),
        row("largest difference of the pulses' carrier from sin(πn/16)", np.abs(np.array(found["carrier"]) - table).max()),
        row("pressure that 16 phases keep, mean over the 18 × 18 positions", 100 * found["kept_mean"], "%", why="by theory sin(x)/x with x = π/16, 99.36 %"),
        row("the same, least of all positions", 100 * found["kept_least"], "%"),
    ]  # fmt: skip


def hoshi_12c(work, name):
    found = work.computed["response"]
    figure, (panel,) = panels(1, (8.5, 4.4))
    panel.semilogx(found["hz"], found["printed_db"], "o-", ms=4, label="bandwidth 2 kHz, as the paper prints")
    panel.semilogx(found["hz"], found["fitted_db"], "s-", ms=4, label=f"bandwidth {found['fitted_hz']:.0f} Hz, fitted to the paper's −5.8 dB")
    panel.plot([10, 1000], [0, -5.8], "x", color="#c0392b", ms=9, mew=2, label="paper, measured: its two numbers")
    panel.set(xlabel="frequency of the modulation / Hz", ylabel="radiation pressure over that at 10 Hz / dB", ylim=(-7, 0.5),
              title="(c) fundamental of the radiation pressure, carrier switched on and off", xticks=[10, 20, 50, 100, 200, 500, 1000])  # fmt: skip
    panel.set_xticklabels(["10", "20", "50", "100", "200", "500", "1000"])
    panel.minorticks_off()
    panel.grid(alpha=0.3)
    legend(panel, loc="lower left")
    save(work, figure, name)
    fitted = "this one bandwidth is fitted to the paper's −5.8 dB, and to nothing else"
    rows = [row(f"at {f} Hz, bandwidth 2 kHz", db, "dB", *((-5.8, "measured", "the printed bandwidth does not give the measured response") if f == 1000 else ()))
            for f, db in zip((200, 500, 1000), found["printed_at"])]  # fmt: skip
    return [
        *rows,
        row("bandwidth that gives −5.8 dB at 1 kHz", found["fitted_hz"], "Hz", 2000.0, "text", fitted),
        row("its time constant", found["fitted_tau_us"], "µs"),
        row("with it, the envelope rises to 90 % in", found["fitted_envelope_90_ms"], "ms", 0.5, "measured", "follows from the fit; the paper does not say to which level"),
        row("with it, the radiation pressure rises to 95 % in", found["fitted_radiation_95_ms"], "ms", 1.0, "measured", "follows from the fit; the paper says nearly 1 ms"),
    ]


def hoshi_eq9(work, name):
    found = {key: np.array(value) for key, value in work.computed["pattern"].items()}
    x, far = found["x_mm"], found["copy_x_mm"]
    figure, axes = panels(2, (12.5, 4.7))
    axes[0].plot(x, found["fresnel"], label="eq. 9 (Fresnel)")
    axes[0].plot(x, found["equal"], "--", label="equal amplitudes, exact distances")
    axes[0].plot(x, found["transform"], label="spherical waves: eq. 9's drives")
    axes[0].plot(x, found["superposition"], lw=1.2, label="superposition, phases alone")
    axes[0].plot(x, found["weighted_gs"], ":", lw=2, color="#222222", label="weighted Gerchberg–Saxton, phases alone")
    for at in (-20, 20):
        axes[0].axvline(at, color="#666666", lw=0.8, ls=":")
    axes[0].set(xlabel="x / mm", ylabel="pressure over that of a single focus", title="two spots asked for at ±20 mm", ylim=(0, 1.05))
    axes[1].plot(far, found["copy_fresnel"], label="eq. 4 (Fresnel)")
    axes[1].plot(far, found["copy_equal"], "--", label="equal amplitudes, exact distances")
    axes[1].plot(far, found["copy_exact"], label="spherical waves")
    axes[1].axvline(float(found["repeats_mm"]), color="#666666", lw=0.8, ls=":", label="λr/d, where eq. 4 repeats")
    axes[1].set(xlabel="x / mm", ylabel="pressure over that of the focus", title="a single focus at x = 0, and its first copy", ylim=(0, 1.05))
    for axis in axes:
        axis.grid(alpha=0.3)
        legend(axis, **({"loc": "upper right"} if axis is axes[0] else {"loc": "upper left", "bbox_to_anchor": (0.06, 1.0)}))
    save(work, figure, name)

    def top(key, at, from_mm, to_mm):
        inside = (at >= from_mm) & (at <= to_mm)
        return at[inside][int(np.argmax(found[key][inside]))], found[key][inside].max()

    spots = {key: top(key, x, 5, 40) for key in ("fresnel", "equal", "transform", "superposition", "gs", "weighted_gs")}
    copies = {key: top(key, far, 150, 260) for key in ("copy_fresnel", "copy_equal", "copy_exact")}
    same = "eq. 9 asks for ±20 mm"
    return [
        row("spot's place by eq. 9 in the Fresnel approximation", spots["fresnel"][0], "mm", 20.0, "theory", same + "; the other spot's side lobe pushes it outwards"),
        row("its pressure over a single focus", spots["fresnel"][1]),
        row("spot's place with exact distances, equal amplitudes", spots["equal"][0], "mm", 20.0, "theory", "the Fresnel approximation is poor at 200 mm from an array of 180 mm"),
        row("spot's place by spherical waves", spots["transform"][0], "mm", 20.0, "theory", "the same, and nearer elements count more"),
        row("its pressure over a single focus", spots["transform"][1]),
        row("spot's place by superposition of exact foci", spots["superposition"][0], "mm", 20.0, "theory", "the other spot's side lobe pushes it outwards"),
        row("its pressure", spots["superposition"][1], why="phases alone: every element at full strength"),
        row("the same by Gerchberg–Saxton", spots["gs"][1]),
        row("the same by weighted Gerchberg–Saxton", spots["weighted_gs"][1]),
        row("first copy of a single focus by eq. 4", copies["copy_fresnel"][0], "mm", 170.0, "theory"),
        row("its pressure over the focus'", copies["copy_fresnel"][1], "", 1.0, "theory"),
        row("first copy with exact distances, equal amplitudes", copies["copy_equal"][0], "mm", 170.0, "theory", "it is farther off, and no copy of the same height"),
        row("its pressure over the focus'", copies["copy_equal"][1], "", 1.0, "theory"),
        row("first copy by spherical waves", copies["copy_exact"][0], "mm", 170.0, "theory"),
        row("its pressure over the focus'", copies["copy_exact"][1], "", 1.0, "theory"),
    ]
