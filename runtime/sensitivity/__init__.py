"""Derivatives of whole runs: through flight, contact and impact (theory, sections 11.5 to 11.8)."""
