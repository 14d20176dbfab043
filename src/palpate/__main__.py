"""`python -m palpate`: the command, where no script of that name is on the path."""

from palpate.cli import main

if __name__ == "__main__":
    main()
