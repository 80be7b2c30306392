"""Pictures of a run: its figure, the figure of its forces, the page that plays it, and the moving picture."""
