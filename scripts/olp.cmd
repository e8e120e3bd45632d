@echo off
rem Runs olp from this checkout, from any folder; sets itself up the first time.
py -3 "%~dp0environment.py" run >nul || exit /b 2
"%~dp0..\.venv\Scripts\python.exe" -P -m olp %*
