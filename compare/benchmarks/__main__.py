"""``python -m compare.benchmarks`` lists the problem sheets."""

from compare.benchmarks.sheets import SHEETS, STATIONS

print("stations x/(c_t T):", *STATIONS)
for sheet in SHEETS.values():
    print(f"{sheet.name:15} {sheet.title}: {', '.join(sheet.report)}")
