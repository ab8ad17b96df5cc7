"""Wrong input of every command: exit status 2 (3: where numerics fail), one line that names it, and nothing written."""

import shlex

import pytest

from validation.commands.cli import INPUT_WRONG, NUMERICS_FAILED

REFUSED = """
run | SCENE
run papr | "paper"
run no/such.toml | no such file
run paper --modle delay | --modle
run paper --model dely | "delay"
run paper --model delay:3 | takes no number
run paper --model delay --model block8 | slipwave: --model: is given more than once
run paper --set V=3 --set size=0.1 --until 5 --json --until=6 | slipwave: --until: is given more than once
run paper --until ten | run.until = 'ten'
run paper --until 60s | run.until = "60s": must come with interface.normal_stress
run paper --until 60 --cycles 3 | cycles = 3: must not be given together with until = 60
run paper --cycles 0 | cycles = 0
run paper --cycles 3 --set run.record=[] | run.record is empty
run paper --set slab.r=1e-3 slab.epsilom=1 | slab.epsilom
run paper --set slab | KEY=VALUE
run paper --model delay --cells 10 | takes no cells
run paper --model delay --tol 0 | tolerance = 0: must lie in [1e-14, 0.1] for model delay
run paper --model dg:7 --cfl 1e-9 | model dg:7: 4000 transits would take about 36
run viscous --model delay | Kelvin-Voigt viscosity
run paper --model dg:5 --time implicit | time = 'implicit': must be exact or explicit
run paper --model fd --time exact | model fd takes no time; models that do: sbp:P, fem:P, dg:P
run paper --model dg:5 --time exact --cfl 0.5 | cfl = 0.5: the exact march has no step limit
stabilty paper | did you mean 'stability'?
compare paper | --models
compare paper --models delay,delay | more than once
compare paper --models delay --out x.doc | .png
report --only nonsense | nonsense
orbits | orbits
--bogus | --bogus
orbit ramp | a periodic orbit needs a constant drive.velocity
orbit paper --model fd | models that do: delay,
orbit paper --tol 1e-20 | tol = 1e-20: must lie in [1e-11, 0.01]
orbit paper --near-period 0 | near_period = '0': must be above 0, in transits or with a unit of time
orbit paper --model kelvin-voigt --set slab.log10_r=-2.72 | 3: has none here: it was followed from log10_r = -2.69955
orbit paper --model quasistatic | 3: it runs away
branch paper --over log10_r=-2.72:-2.68 --switch LP | --switch 'LP': must be HB or PD
branch paper | --over: missing; must be KEY=FROM:TO
branch paper --over log10_r=-2.7:-2.7 | must differ
branch paper --over 'slab.thickness=1 mm:2' | FROM and TO must both have a unit, or none
branch paper --over nothing=1:2 | 'nothing' is no parameter; must be one of r, epsilon, V,
branch paper --over epsilon=-1:1 | slab.epsilon = -1.0: must be
branch paper --over log10_r=-3:-2.8 | is stable at both ends
branch paper --over log10_r=-2.72:-2.68 --stop-at XX | --stop-at 'XX': must be one of HB, LP, PD, NS
branch paper --over log10_r=-2.72:-2.68 --resume missing.nc | no such file
branch paper --over log10_r=-2.6:-2.5 --set start.size=0 | 3: made 0 cycles
curve paper --of XX --over log10_r=-2.72:-2.68 --and V=100:120 | slipwave: --of 'XX': must be one of HB, LP, PD, NS
curve paper --of LP --over log10_r=-2.72:-2.68 --and log10_r=-2:-3 | --and 'log10_r': must be another parameter than --over
curve paper --of HB --over log10_r=-2.72:-2.68 --and interface.a_star=0.3:0.4 | of Hopf points needs one of r, epsilon, V
curve paper --of HB --over r=1e-3:2e-3 --and V=1:2 --resume x.nc | --resume: a curve of Hopf points is computed at once
curve paper --over log10_r=-2.72:-2.68 --and V=100:120 | slipwave: --of: missing; must be given, as in --of LP
curve paper --of PD --over log10_r=-2.72:-2.695 --and V=100:120 --tol 1e-4 | 3: no period doubling was found on the branch
verify | give a SCENE, --family FILE.py, --law FILE.py or --model NAME
verify --model delay | has no grid, so no order and no step limit to verify; models that do: fd, sbp:P, fem:P, dg:P
verify viscous --model sbp:9 | must be sbp:P with one of 2, 4, 6
verify paper --junit v.txt | the name must end in .xml
sweep paper --out x | --vary: missing
sweep paper --out x --vary log10_r=-2.7:-2.2 | FROM:TO:COUNT
sweep rock --out x --vary 'slab.thickness=1 m:2:3' | same unit
sweep paper --out x --vary a=0:0.02:3:log | above 0
sweep paper --out x --vary a=0.01:0.02:50000 --vary b=0.03:0.04:50000 | 1e8
sweep paper --out x --vary a=0.01:0.02:4 --refine 2 | as 5
sweep paper --out x --vary a=0.01:0.02:3 --part 4/3 | --part
sweep paper --out x --vary a=0.01:0.02:3 --part 1/3 --anew | --anew, which removes
sweep paper --out x --rows nothing.csv | --rows
map nothing.nc | neither a folder
"""


@pytest.mark.parametrize("line", REFUSED.strip().splitlines())
def test_wrong_input_is_one_line_and_nothing_is_written(refused, tmp_path, monkeypatch, line):
    monkeypatch.chdir(tmp_path)
    words, told = line.split(" | ")
    status = NUMERICS_FAILED if told.startswith("3: ") else INPUT_WRONG
    found = refused(*shlex.split(words), status=status)
    assert told.removeprefix("3: ").lower() in found.lower()
    assert list(tmp_path.iterdir()) == []
