"""The report: folders of runs and of the theory in, one page with figures and tables out (no JAX)."""

from gsiirl.report.ablation_page import write_ablation_page as write_ablation_page
from gsiirl.report.build import ReportFiles as ReportFiles
from gsiirl.report.build import build_report as build_report
from gsiirl.report.theory_page import write_theory_page as write_theory_page
