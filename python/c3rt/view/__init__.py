"""What happens on the bus, live in a browser: arm and objects, the plan, forces, candidates, figures; buttons and targets.

`c3rt view` starts it for the instance that runs. Needs the extra `view`: pip install './python[view]'.
"""
