# SPDX-License-Identifier: Apache-2.0
"""Studies with people: protocols, a runner, simulated observers, statistics, and checks of printed numbers. `python3 -m haptogram_study --help`.

Protocols, the runner and the observers need Python alone. `analyse`, `power`, `printed` and the figures also need the packages of the
extra `study`: scipy, pandas, statsmodels."""
