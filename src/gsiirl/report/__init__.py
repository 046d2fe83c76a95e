"""The report: reads folders of runs and of the theory, writes one page with figures and tables (no JAX).

Each folder imports only folders further left, never one further right or one between the same bars:

words | figures | output | read | curves | tables | security, plane | crossing, deception | theory | ablation | page
"""

from gsiirl.report.ablation.page import write_ablation_page as write_ablation_page
from gsiirl.report.page.build import ReportFiles as ReportFiles
from gsiirl.report.page.build import build_report as build_report
from gsiirl.report.tables.swept import swept_table as swept_table
from gsiirl.report.theory.page import write_theory_page as write_theory_page
