# SPDX-License-Identifier: Apache-2.0
"""The page with each picture beside its table."""

import html

from haptogram_study import printed


def number(value):
    return "" if value is None else f"{value:.4g}" if abs(value) < 9999.5 else f"{value:.0f}"


def difference(line):
    if line["paper"] is None:
        return ""
    apart = line["ours"] - line["paper"]
    if abs(apart) < 5e-4 * abs(line["paper"]):
        return "none"
    percent = f" ({100 * apart / line['paper']:+.3g} %)" if line["unit"] != "%" and line["paper"] != 0 else ""
    unit = "points" if line["unit"] == "%" else line["unit"]
    return f"{apart:+.3g}{' ' + unit if unit else ''}{percent}"


STYLE = """body{font:16px/1.5 system-ui,sans-serif;margin:0 auto;max-width:72rem;padding:1rem;color:#222;background:#fff}
img{max-width:100%;height:auto;display:block}h2{margin:2.5rem 0 .5rem;font-size:1.25rem}
.wide{overflow-x:auto}table{border-collapse:collapse;width:100%;font-size:.9rem}
th,td{text-align:left;vertical-align:top;padding:.3rem .6rem;border-bottom:1px solid #ccc}td.n{white-space:nowrap}
@media(prefers-color-scheme:dark){body{color:#ddd;background:#161616}th,td{border-color:#444}a{color:#8bf}}"""


def page(figures):
    e = html.escape
    parts = [
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>Haptogram: the papers' figures, computed</title><style>{STYLE}</style></head><body>",
        "<h1>The papers' figures, computed</h1><p>Every number under “ours” was computed in the run that wrote this page (<code>make figures</code>). "
        "Where the paper's number is a measurement, ours is the theory's for the same set-up, and the last column says what is known of the "
        "difference. Nothing is tuned to agree, but for one bandwidth in Hoshi's Fig. 12c, which is named there. “Haptogram” is the paper of this system, “Hoshi” is T. Hoshi et al., <em>Noncontact Tactile "
        "Display Based on Radiation Pressure of Airborne Ultrasound</em>, and “Multimodal” is the paper of a cable robot beside ultrasound, doi:10.1109/JSEN.2022.3144888. "
        "Where Multimodal prints no number, a row has one that follows from what it prints by other means than our program, and says by which. "
        "The fields of the point, the line, the circles and the hemisphere come from the pulses measured "
        'at the pins of the Verilated FPGA, each of one pass; they are steady ones, each point\'s with its full pressure: '
        'what ring-up and switching cost has figures of its own. The same numbers: <a href="figures.json">figures.json</a>.</p><ul>',
        *(f'<li><a href="#{f["id"]}">{e(f["title"])}</a></li>' for f in figures),
        '<li><a href="#printed">All numbers that the papers print about their studies and formulas</a></li>',
        "</ul>",
    ]
    for f in figures:
        parts.append(f'<h2 id="{f["id"]}">{e(f["title"])}</h2><img src="{f["picture"]}" alt="{e(f["title"])}">')
        parts.append('<div class="wide"><table><thead><tr><th>what</th><th>paper</th><th>ours</th><th>difference</th><th>why</th></tr></thead><tbody>')
        for line in f["rows"]:
            unit = f" {line['unit']}" if line["unit"] else ""
            paper = f"{number(line['paper'])}{unit}, {line['kind']}" if line["paper"] is not None else "–"
            parts.append(
                f'<tr><td>{e(line["what"])}</td><td class="n">{e(paper)}</td><td class="n">{e(number(line["ours"]) + unit)}</td>'
                f'<td class="n">{e(difference(line))}</td><td>{e(line["why"])}</td></tr>'
            )
        parts.append("</tbody></table></div>")
    parts.append('<h2 id="printed">What the papers print, and what follows from it</h2><div class="wide"><table><thead><tr><th>paper</th>'
                 "<th>where</th><th>what</th><th>printed</th><th>ours</th><th>verdict</th><th>note</th></tr></thead><tbody>")  # fmt: skip
    for line in printed.recompute():
        cells = (line.paper, line.where, line.what, *printed.with_units(line), line.verdict, line.note)
        parts.append("<tr>" + "".join(f"<td>{e(cell)}</td>" for cell in cells) + "</tr>")
    parts.append("</tbody></table></div>")
    return "\n".join(parts) + "\n</body></html>\n"
