"""Run the command line with `python -m phichain`."""

from phichain.app.cli import main

if __name__ == "__main__":
    main()
