"""Do the cases and tests notice bugs? Planted ones (planted.py) and generated ones (generated.py); see docs/MUTANTS.md."""
