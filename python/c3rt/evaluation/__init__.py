"""Many runs of scenarios: what `c3rt campaign`, `c3rt tune` and `c3rt reproduce` become.

Needs nothing but Python: it starts the programs of c3rt and reads what they leave. The package `distributed` is needed for
`--engine dask`, `cmaes` for the search, `matplotlib` for pictures.
"""
