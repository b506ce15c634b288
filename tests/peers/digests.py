"""What ros_digest says of recordings, against what another reader does."""
import subprocess


def compare(program, *recordings, digest, values=True):
    """`digest` gives a recording's lines as the program prints them; those end with two columns for the values of
    scans, which are left out without `values`. Prints the differences. Returns the exit code: 1 where there are any."""
    if not recordings:
        print('SKIPPED: no recordings, MARCO_TEST_DATA is not set')
        return 0
    wrong = 0
    for path in recordings:
        lines = subprocess.run([program, path], check=True, capture_output=True, text=True).stdout.splitlines()
        ours = set(lines if values else (line.rsplit(' ', 2)[0] for line in lines))
        theirs = digest(path)
        print(f'{path}: {len(theirs)} topics, {len(ours ^ theirs)} differences')
        for line in sorted(ours ^ theirs):
            print('  ' + ('ours:   ' if line in ours else 'theirs: ') + line)
        wrong += len(ours ^ theirs) + (not theirs)
    return 1 if wrong else 0
