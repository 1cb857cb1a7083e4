"""The tables and figures of `c3rt reproduce`: one function each, of a Reproduction."""
