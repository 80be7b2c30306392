"""Derivatives of whole runs: through flight, contact and impact (docs/theory.md, sections 11.5 to 11.8)."""
