"""Run the command line with `python -m phichain`."""

from phichain.cli import main

if __name__ == "__main__":
    main()
