"""Design a badge and write the page to print: run with a folder, `python examples/01_print_a_badge.py out`."""

import sys
from pathlib import Path

import moireid as mo
from moireid.designer import Order, design_badge, explain, random_payload


def main(folder: Path) -> None:
    """Print a badge for Ada into `folder`, without a mount."""
    badge = design_badge(Order("Ada Lovelace", lens="50lpi", range_m=(0.8, 2.0)), random_payload())
    printed = mo.print_badge(badge, folder, mount="none", overwrite=True)
    for what, figure in explain(badge):
        print(f"{what:<26} {figure}")
    print("written:", ", ".join(sorted(printed.files)))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
