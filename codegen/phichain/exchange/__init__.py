"""Exchange: a scene as what other tools open."""

from phichain.exchange.fmu import write_fmu

__all__ = ["write_fmu"]
