"""Studies: one task at thousands or millions of points, on this machine or on many, interrupted and extended at will."""

from phichain.studies.dataset import open_study, write_netcdf
from phichain.studies.document import load_plan, plan_of
from phichain.studies.plan import Plan
from phichain.studies.run import Studied, study

__all__ = ["Plan", "Studied", "load_plan", "open_study", "plan_of", "study", "write_netcdf"]
