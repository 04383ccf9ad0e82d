# Short commands for development. Each uses .venv, which `make setup` makes.
.PHONY: setup test lint docs app bench lock

setup:
	python3 -m venv .venv
	.venv/bin/pip install -e ".[dev,docs,exchange]" "ruff==0.17.*" "mypy==2.4.*" "pandas-stubs==3.1.*"

test:
	.venv/bin/python -m pytest -n 2

lint:
	.venv/bin/ruff format .
	.venv/bin/ruff check .
	.venv/bin/mypy

docs:
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict

app:
	.venv/bin/streamlit run app.py

bench:
	.venv/bin/python -m pytest tests/benchmarks --benchmark-only

# The versions that are installed, of what requirements.txt names and of what that needs
lock:
	.venv/bin/python .ci/lock.py > requirements.lock
