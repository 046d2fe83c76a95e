"""The report: run folders in, one page with figures and tables out (no JAX)."""

from gsiirl.report.build import ReportFiles as ReportFiles
from gsiirl.report.build import build_report as build_report
