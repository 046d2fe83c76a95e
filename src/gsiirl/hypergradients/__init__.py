"""How the learner's objective changes with θ_l, the expert's response included: vectors and callables, no games."""

from gsiirl.hypergradients.finite_difference import FiniteDifference as FiniteDifference
from gsiirl.hypergradients.finite_difference import coordinate_jacobian as coordinate_jacobian
from gsiirl.hypergradients.hvp_cg import HessianVectorCG as HessianVectorCG
from gsiirl.hypergradients.implicit import Implicit as Implicit
from gsiirl.hypergradients.problem import AbstractEstimator as AbstractEstimator
from gsiirl.hypergradients.problem import AbstractStatelessEstimator as AbstractStatelessEstimator
from gsiirl.hypergradients.problem import BilevelProblem as BilevelProblem
from gsiirl.hypergradients.problem import Hypergradient as Hypergradient
from gsiirl.hypergradients.problem import ResponseKind as ResponseKind
from gsiirl.hypergradients.spsa import SPSA as SPSA
from gsiirl.hypergradients.spsa import SPSAState as SPSAState
from gsiirl.hypergradients.spsa import directional_jacobian as directional_jacobian
