"""Tables and rows of what evaluate.py measured.

In: the results of runs. Out: Markdown, and a CSV file with a row for each. Nothing here runs a program.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from evaluate import Result
    from scoring import Reported, Score


def said(churn: float | None, camera: str | None) -> str:
    """What is not as usual in a run."""
    return "".join([f" churn {churn:g}" if churn else "", f" camera {camera}" if camera else ""])


def markdown(rows: list[dict[str, str]]) -> str:
    heads = list(rows[0])
    lines = [heads, ["---"] + ["---:"] * (len(heads) - 1), *([row[head] for head in heads] for row in rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def row(name: str, score: Score) -> dict[str, str]:
    def in_time(kind: Reported) -> str:
        return f"{kind.in_time} / {kind.true}"

    return {
        "scene": name,
        "IDF1": f"{score.ours.idf1:.4f}",
        "MOTA": f"{score.ours.mota:.4f}",
        "switches / 1,000 frames": f"{score.ours.switches_per_1000:.2f}",
        "splits in time": in_time(score.splits),
        "mergers in time": in_time(score.mergers),
        "false": str(score.splits.false + score.mergers.false),
        "rival: IDF1": f"{score.rival.idf1:.4f}",
        "rival: switches / 1,000 frames": f"{score.rival.switches_per_1000:.2f}",
    }


def total(results: Iterable[Result]) -> Score:
    first, *rest = (result.score for result in results)
    return sum(rest, start=first)


def tables(results: list[Result]) -> str:
    def group(result: Result) -> tuple[float, str, str]:
        return result.run.noise, result.selection, said(result.run.churn, result.run.camera)

    groups = sorted({group(result) for result in results})
    has_selections = {selection for _, selection, _ in groups} != {"above"}
    parts = []
    for noise, selection, others in groups:
        chosen = [result for result in results if group(result) == (noise, selection, others)]
        names = list(dict.fromkeys(result.run.scene for result in chosen))
        rows = [row(name, total(result for result in chosen if result.run.scene == name)) for name in names]
        rows.append(row("**all**", total(chosen)))
        what = "".join(f", {word}" for word in (selection * has_selections, others.strip()) if word)
        parts.append(f"Noise {noise:g} of the radius{what}, {len(chosen)} runs:\n\n{markdown(rows)}\n")
    if len(groups) > len({noise for noise, _, _ in groups}):
        parts.append(f"All:\n\n{summary(results)}\n")
    return "\n".join(parts)


def summary(results: list[Result]) -> str:
    """A row for each selection, churn and noise; runs with a camera apart."""

    def group(result: Result) -> tuple[str, str, str]:
        run = result.run
        return result.selection, said(run.churn, "moves" if run.camera else None).strip() or "as usual", f"{run.noise:g}"

    rows = []
    for selection, others, noise in sorted({group(result) for result in results}):
        chosen = [result for result in results if group(result) == (selection, others, noise)]
        score = total(chosen)
        rows.append(
            {
                "selection": selection,
                "scene": others,
                "noise": noise,
                "runs": str(len(chosen)),
                "IDF1 >= 0.99, no switch": f"{share_of_good(chosen):.3f}",
                "least IDF1": f"{min(result.score.ours.idf1 for result in chosen):.4f}",
                "IDF1": f"{score.ours.idf1:.4f}",
                "switches": str(score.ours.switches),
                "splits in time": f"{score.splits.in_time} / {score.splits.true}",
                "mergers in time": f"{score.mergers.in_time} / {score.mergers.true}",
                "again": str(score.splits.again + score.mergers.again),
                "false": str(score.splits.false + score.mergers.false),
            }
        )
    return markdown(rows)


def share_of_good(results: list[Result]) -> float:
    return sum(not result.faults() for result in results) / max(len(results), 1)


def flat(result: Result) -> dict[str, Any]:
    """A row of the CSV."""
    score = result.score
    cells: dict[str, Any] = {**asdict(result.run), "points_per_radius": result.points_per_radius}
    cells |= {"selection": result.selection, "rule": " ".join(result.rule)}
    for who, identity in (("", score.ours), ("rival_", score.rival)):
        cells |= {f"{who}idf1": f"{identity.idf1:.6f}", f"{who}mota": f"{identity.mota:.6f}"}
        cells |= {f"{who}{name}": value for name, value in asdict(identity).items()}
    for name, kind in (("splits", score.splits), ("mergers", score.mergers)):
        cells |= {f"{name}_{each}": value for each, value in asdict(kind).items()}
    return cells


def write_csv(path: Path, results: list[Result]) -> None:
    rows = [flat(result) for result in results]
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
