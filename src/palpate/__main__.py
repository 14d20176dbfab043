"""Run the command line as `python -m palpate`."""

from palpate.cli import main

if __name__ == "__main__":
    main()
