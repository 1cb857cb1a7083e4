"""Many runs of scenarios: what `c3rt campaign` and `c3rt tune` become, and who makes runs for `c3rt reproduce`.

Needs nothing but Python: it starts the programs of c3rt and reads what they leave. The package `distributed` is needed for
`--engine dask`, `cmaes` for the search.
"""
