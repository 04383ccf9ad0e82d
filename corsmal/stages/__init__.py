"""One recording's stages with the store behind them: detections, fits, estimates, what was known when."""
