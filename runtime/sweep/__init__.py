"""Sweeps: runs that a plan asks for, made part by part into a folder that can be gone on with."""
