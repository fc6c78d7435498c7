# Thin: dev.py does the work and sets up what is missing.
PYTHON ?= python3

.PHONY: help setup demo test fast addon test-addon lint docs site examples lock
help:
	@$(PYTHON) dev.py --help
setup demo test fast addon test-addon lint docs site examples lock:
	@$(PYTHON) dev.py $@
