"""A small study, as a scenario file."""

SCENARIO = """
[world]
model = "monobot"
landmarks = 2
[study]
runs = 200
steps = 20
seed = 3
"""
