# Run in a clean system that has Debian's Python: the wheel beside this script is installed with what it depends on, and
# tried.
export PATH=/venv/bin:$PATH
python3 -m venv /venv
pip --quiet install --no-index --find-links /trial sextant
exec python /trial/installed.py
