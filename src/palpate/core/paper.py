"""The paper whose sensor is the default of every stage."""

DOI = "10.1016/j.sna.2024.115469"
PAPER = f"Zaid et al. 2024, doi {DOI}"
