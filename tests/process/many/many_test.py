#!/usr/bin/env python3
"""marco map --many on short simulated recordings, while workers, and the command itself, are killed at random: each is
mapped once, nothing is begun again that was done, and the table is complete.

usage: many_test.py BIN-FOLDER SOURCE-FOLDER [--logs N]
"""
import argparse
import collections
import csv
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

TOUR = '''start_m = [2.0, 3.0]
start_heading_deg = 0
[[steps]]
to_m = [{x:.2f}, 2.4]
'''


def simulate(program, root, folder, logs, seed):
    tour = folder / 'tour.toml'
    for i in range(logs):
        tour.write_text(TOUR.format(x=3.0 + 0.01 * i))
        subprocess.run([program, '--world', root / 'config/worlds/lab.toml', '--tour', tour, '--seed', str(seed + i),
                        '--out', folder / f'run_{i:03}.lcm'], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
    tour.unlink()
    (folder / 'broken.lcm').write_bytes((folder / 'run_000.lcm').read_bytes()[:2000])  # no scans


def split(program, log, folder):
    """The log as a bag in three parts, as rosbag splits, and another bag beside them."""
    for part, times in enumerate((['--to', '2'], ['--from', '2', '--to', '4'], ['--from', '4'])):
        cut = folder / 'cut.lcm'
        subprocess.run([program, 'cut', log, cut, '--force'] + times, check=True, stdout=subprocess.DEVNULL)
        subprocess.run([program, 'convert', cut, folder / f'split_{part}.bag'], check=True, stdout=subprocess.DEVNULL)
        cut.unlink()
    subprocess.run([program, 'convert', log, folder / 'whole.bag'], check=True, stdout=subprocess.DEVNULL)


def workers_of(pid):
    try:
        return [int(child) for child in pathlib.Path(f'/proc/{pid}/task/{pid}/children').read_text().split()]
    except OSError:
        return []


def run_and_kill(command, chance, kills, whole_kills):
    """Runs until the command ends by itself. Kills what it started, and now and then the command."""
    while True:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        was_killed = False
        while process.poll() is None:
            time.sleep(chance.uniform(0.0, 1.0))
            below = workers_of(process.pid)
            if kills['workers'] < whole_kills * 4 and below:
                os.kill(chance.choice(below), signal.SIGKILL)
                kills['workers'] += 1
            elif kills['commands'] < whole_kills and below:
                process.kill()
                kills['commands'] += 1
                was_killed = True
        if not was_killed:
            return process.returncode, process.stdout.read()


def check(what, holds):
    if not holds:
        print(f'FAILED: {what}')
        sys.exit(1)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('bin', type=pathlib.Path)
    parser.add_argument('root', type=pathlib.Path)
    parser.add_argument('--logs', type=int, default=4)
    arguments = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix='marco_many_'))
    chance = random.Random(5)
    try:
        logs, out = folder / 'logs', folder / 'out'
        logs.mkdir()
        simulate(arguments.bin / 'marco-simulate', arguments.root, logs, arguments.logs, 1)
        split(arguments.bin / 'marco-log', logs / 'run_000.lcm', logs)
        kills = collections.Counter()
        command = [arguments.bin / 'marco-map-many', logs, '--out', out, '--jobs', '2']
        code, said = run_and_kill(command, chance, kills, max(1, arguments.logs // 20))
        print(f'{said.strip()} after {kills["workers"]} workers and {kills["commands"]} commands were killed')
        check('the broken log is reported by the exit code', code == 1)
        rows = list(csv.DictReader(open(out / 'table.csv')))
        check('every log has a row', sorted(row['log'] for row in rows) ==
              sorted(['broken', 'split', 'whole'] + [f'run_{i:03}' for i in range(arguments.logs)]))
        for row in rows:
            broken = row['log'] == 'broken'
            check(f'{row} is what it should be', (row['verdict'] == 'failed') == broken and row['verdict'] != 'not done')
            check(f'{row} has its picture and scans', broken or (int(row['scans']) > 5 and (out / row['picture']).is_file()))
        scans = {row['log']: row['scans'] for row in rows}
        check(f'a split recording has all scans: {scans}', scans['split'] == scans['whole'])
        page = (out / 'index.html').read_text()
        check('the page has a row for each', all(f'>{row["log"]}</a>' in page for row in rows))
        check('the page shows each map', 
              all(f'src="{row["picture"]}"' in page for row in rows if row['verdict'] != 'failed'))
        ends = collections.Counter()
        for line in open(out / 'jobs/journal.csv'):
            _, name, what = line.strip().split(',')
            check(f'{name} is not begun again when it was done', ends[name] == 0)
            ends[name] += what in ('done', 'failed')
        # A worker that was killed between the results and its line leaves none; the results count.
        check('none was done twice', max(ends.values()) == 1)
        before = {path: path.stat().st_mtime_ns for path in out.glob('*/report.json')}
        check('the command does nothing twice', subprocess.run(command, stdout=subprocess.DEVNULL).returncode == 1)
        check('the results are the same', before == {p: p.stat().st_mtime_ns for p in out.glob('*/report.json')})
        check('other options are refused', subprocess.run(command + ['--', '--lines'], stdout=subprocess.DEVNULL,
                                                          stderr=subprocess.DEVNULL).returncode == 1)
        leftovers = list(out.glob('*.part'))
        check(f'nothing is left over: {leftovers}', not leftovers)
        print('each done once, the table is complete')
    finally:
        shutil.rmtree(folder)


if __name__ == '__main__':
    main()
