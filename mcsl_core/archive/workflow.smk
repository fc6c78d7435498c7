# What is done for every operation, for Snakemake: `mcsl archive` runs it. All of it is mcsl's own commands.
#
# Outputs are marks alone, each with the seconds it took: Snakemake deletes a job's outputs before it runs it again and
# when it fails, and an EDL holds an editor's overrides, a chunk an hour's work. Commands themselves skip what is there.

import json
from functools import cache
from pathlib import Path

OPERATIONS = config["operations"]
# Beside a mark lies when its job began, by the clock of the files: what an editor decides while it is at work it has not
# seen. The mark itself Snakemake touches in the end.
_CALL = config["mcsl"].replace("{", "{{").replace("}", "}}")
MCSL = f"SECONDS=0; : > {{output:q}}.began; {_CALL} --progress json"
ANONYMOUS = "--anonymous" if config.get("anonymous") else ""
MARK = " > {log:q} 2>&1 && echo $SECONDS > {output:q}"
END = "--allow-outside" + MARK


@cache
def job(operation):
    return json.loads(Path(operation, "job.json").read_text("utf-8"))


def hours(share):
    """Minutes that a job may take: for each hour of recording so many of work, and one to begin with."""
    return lambda wildcards, attempt: round(attempt * 60 * (1 + share * job(wildcards.op)["facts"]["seconds"] / 3600))


def decided(wildcards):
    """The analysis, and the EDL again once an editor has changed it since."""
    edl = f"{wildcards.op}/edl.json"
    return [f"{wildcards.op}/done/analyse", *([edl] if Path(edl).exists() else [])]


def parts(wildcards):
    of = job(wildcards.op)["parts"]
    return [f"{wildcards.op}/done/conform-{part}-of-{of}" for part in range(1, of + 1)]


wildcard_constraints:
    op=r"[^/]+",
    part=r"\d+",
    of=r"\d+",


localrules:
    all,


rule all:
    input:
        [f"{op}/done/{last}" for op in OPERATIONS for last in ("render", "report")],


rule analyse:
    input:
        "{op}/job.json",
    output:
        "{op}/done/analyse",
    log:
        "{op}/log/analyse.jsonl",
    params:
        options=lambda w: job(w.op)["analyse"],
    threads: config["threads"]
    retries: 2
    resources:
        mem_mb=4096,
        runtime=hours(8),
    shell:
        MCSL + " analyse {wildcards.op:q}/recording -o {wildcards.op:q}/edl.json {params.options:q}" + MARK


rule conform:
    input:
        decided,
    output:
        "{op}/done/conform-{part}-of-{of}",
    log:
        "{op}/log/conform-{part}-of-{of}.jsonl",
    params:
        options=lambda w: job(w.op)["conform"],
    threads: config["threads"]
    retries: 2
    resources:
        mem_mb=4096,
        runtime=hours(8),
    shell:
        MCSL + " conform {wildcards.op:q}/edl.json --part {wildcards.part}/{wildcards.of} --jobs {threads}"
        " {params.options:q} " + END


rule render:
    input:
        parts,
    output:
        "{op}/done/render",
    log:
        "{op}/log/render.jsonl",
    params:
        options=lambda w: job(w.op)["render"],
        video=lambda w: job(w.op)["video"],
    threads: config["threads"]
    retries: 2
    resources:
        mem_mb=4096,
        runtime=hours(4),
    shell:
        MCSL + " render {wildcards.op:q}/edl.json -o {wildcards.op:q}/{params.video} --engine direct"
        " {params.options:q} " + END


rule evaluate:
    input:
        decided,
    output:
        "{op}/done/evaluate",
    log:
        "{op}/log/evaluate.jsonl",
    retries: 2
    resources:
        mem_mb=4096,
        runtime=hours(8),
    shell:
        MCSL + " evaluate {wildcards.op:q}/edl.json --every 30 --json {wildcards.op:q}/figures.json " + END


rule report:
    input:
        "{op}/done/evaluate",
    output:
        "{op}/done/report",
    log:
        "{op}/log/report.jsonl",
    retries: 2
    resources:
        mem_mb=4096,
        runtime=hours(1),
    shell:
        MCSL + " report {wildcards.op:q}/edl.json -o {wildcards.op:q}/report.html"
        " --figures {wildcards.op:q}/figures.json " + ANONYMOUS + " " + END
