# %% [markdown]
# # Measure your own sheet
#
# A lens sheet's pitch is seldom that of its label.  Print the pitch test, lay the sheet on it, and film it: the bands
# show the pitch.  Here a simulated camera films a sheet of 50 lenses to the inch that is 0.2 % too wide.

# %%
import sys
from pathlib import Path

import moireid as mo
from moireid.calibration.sheet_reading import read_sheet
from moireid.designer import design_chart
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.profiles import save_profile

folder = Path(sys.argv[1] if len(sys.argv) > 1 and "ipykernel" not in sys.modules else "out")
folder.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The chart

# %%
chart = design_chart(lens="50lpi")
write_badge_pdf(chart, folder / "pitch_test.pdf")
print(chart)

# %% [markdown]
# ## A film of it
#
# In place of this line, film or photograph the printed chart under your sheet.

# %%
film = mo.simulate(
    chart,
    folder / "chart.mp4",
    motion="linear",
    distance_m=1.0,
    frames=30,
    fps=30,
    build="ideal",
    flaws=["lens-scale=1.002"],
).video

# %% [markdown]
# ## What the film shows

# %%
found = read_sheet(film, chart, distance_m=1.0)
sheet = found.profile
built = 1.002 * chart.lens.pitch_mm
print(f"pitch {sheet.lens.pitch_mm:.4f} mm ± {1000 * sheet.pitch_sd_mm:.2f} um; built {built:.4f} mm")

# %% [markdown]
# ## A badge for this very sheet

# %%
save_profile(sheet, folder / "my_sheet.json")
badge = mo.design("Ada Lovelace", lens=folder / "my_sheet.json")
print(badge)
badge  # noqa: B018
