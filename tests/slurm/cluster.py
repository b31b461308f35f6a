"""A Slurm cluster of this one machine, in a folder: munge, slurmctld and slurmd, and their end."""

import os
import socket
import subprocess
import time
from pathlib import Path

from tests.program import ENVIRONMENT

PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"
CORES = 6  # said to have, of two hyper-threads each, so that jobs run side by side
CONFIGURATION = """\
ClusterName=hpcrub
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control_port}
SlurmdPort={node_port}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=2,bf_interval=2
MpiDefault=pmix
ReturnToService=2
MailProg=/bin/true
MinJobAge=3600
NodeName={host} NodeAddr=127.0.0.1 CoresPerSocket={cores} ThreadsPerCore=2 RealMemory=16000 \
    State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=UNLIMITED State=UP
"""


def _free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


class Cluster:
    """The daemons, from start to stop."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.daemons = []
        self.environment = (
            os.environ
            | ENVIRONMENT
            | {
                "PATH": PATH,
                "SLURM_CONF": str(self.folder / "slurm.conf"),
                "HPCRUB_SITE": "./site.sh",  # of the folder that a job is submitted from
            }
        )

    def start(self):
        """Raises RuntimeError when the node does not become idle."""
        host = socket.gethostname().partition(".")[0]
        for name in ("state", "spool"):
            (self.folder / name).mkdir(parents=True)
        (self.folder / "slurm.conf").write_text(
            CONFIGURATION.format(
                host=host,
                folder=self.folder,
                cores=CORES,
                control_port=_free_port(),
                node_port=_free_port(),
            )  # fmt: skip
        )
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        files = {"key-file": "key", "pid-file": "pid", "seed-file": "seed", "socket": "socket"}
        munge = [f"--{option}={self.folder}/munge.{name}" for option, name in files.items()]
        self._daemon("munged", "--foreground", "--force", *munge)
        self._daemon("slurmctld", "-D", "-c")
        self._daemon("slurmd", "-D", "-N", host)
        deadline = time.monotonic() + 30
        while "idle" not in self.ask("sinfo", "--noheader", "--format=%T"):
            if time.monotonic() > deadline:
                logs = [path.read_text()[-1500:] for path in self.folder.glob("*.log")]
                raise RuntimeError("the node does not become idle:\n" + "\n".join(logs))
            time.sleep(0.2)

    def stop(self):
        """End all jobs, then the daemons."""
        self.ask("scancel", "--partition=test")
        deadline = time.monotonic() + 40
        while self.ask("squeue", "--noheader") and time.monotonic() < deadline:
            time.sleep(0.2)
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(timeout=10)
            except subprocess.TimeoutExpired:
                daemon.kill()

    def ask(self, *command):
        """Output of one of Slurm's commands."""
        return self.run(*command).stdout.strip()

    def run(self, *command, folder=None):
        """A finished command in the cluster's environment."""
        options = {"cwd": folder, "env": self.environment, "timeout": 120}
        return subprocess.run(command, capture_output=True, text=True, **options)

    def _daemon(self, *command):
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.daemons.append(subprocess.Popen(command, env=self.environment, **silent))
