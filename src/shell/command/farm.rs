//! The command `farm`: a render divided into tasks, as a job script or template of a queue.

use super::arguments::{Arguments, Command, Farm, Queue, Render};
use super::common::{Failure, bad, failed, say};
use super::load::load;
use super::render::output_name;
use clap::Parser;
use pmcip::animation::sequence;
use pmcip::frame::checkpoint;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Options by which a task differs from the render asked for; they are taken out of that.
const DIVIDED: [&str; 7] =
    ["--frames", "--seed", "--output", "-o", "--checkpoint", "--threads", "--progress"];
/// The same without a value.
const FLAGS: [&str; 3] = ["--resume", "--film", "--quiet"];

/// Stands for a task's frames or seed: no argument can have it.
const PART: &str = "\0";

/// A render in tasks.
struct Tasks {
    /// What the tasks have in common, after the program's name.
    command: Vec<String>,
    name: PathBuf,
    by: Division,
    /// Threads of a task, if that is said.
    threads: Option<usize>,
}

enum Division {
    /// Frames of each task, as `--frames` takes them.
    Frames(Vec<String>),
    /// Number of films of one frame, and their first seed.
    Seeds(u32, u32),
}

pub fn divide(arguments: &Farm) -> Result<(), Failure> {
    let words = std::iter::once("pmcip".to_owned()).chain(arguments.render.iter().cloned());
    let parsed = Arguments::try_parse_from(words).map_err(|why| bad(first_line(&why.to_string())))?;
    let Command::Render(render) = parsed.command else { return Err(bad("only `render` can be divided")) };
    let mut tasks = tasks(arguments, &render)?;
    match arguments.queue {
        Queue::Slurm => say(&tasks.slurm(arguments.checkpoint)),
        Queue::Openjd => {
            tasks.name_whole_paths().map_err(failed)?;
            say(&tasks.openjd(arguments.checkpoint));
        }
    }
    Ok(())
}

/// The first line of a refusal, without the word it begins with.
fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default().trim_start_matches("error: ")
}

fn tasks(arguments: &Farm, render: &Render) -> Result<Tasks, Failure> {
    if render.missing || render.video.is_some() || render.live.is_some() {
        return Err(bad("--missing, --video and --live are of a whole run: not of its tasks"));
    }
    let animation = load(&render.common, render.exposure)?;
    let name = output_name(render, animation.scene());
    let by = match (&render.frames, arguments.seeds) {
        (Some(_), Some(_)) => return Err(bad("--seeds divides one frame: give no --frames")),
        (None, None) => return Err(bad("one frame is divided by --seeds, an animation by its --frames")),
        (None, Some(count)) => match render.common.seed.checked_add(count - 1) {
            Some(_) => Division::Seeds(count, render.common.seed),
            None => return Err(bad("--seeds: the last seed is beyond 2^32 - 1")),
        },
        (Some(list), None) => {
            let frames = list.within(animation.frames().map(|f| (f.first, f.last))).map_err(bad)?;
            Division::Frames(frames.chunks(arguments.chunk as usize).map(sequence::compact).collect())
        }
    };
    Ok(Tasks { command: common(&arguments.render), name, by, threads: render.common.threads })
}

/// The words of a command without those that differ from task to task.
fn common(words: &[String]) -> Vec<String> {
    let mut kept = Vec::new();
    let mut words = words.iter();
    while let Some(word) = words.next() {
        // `--name=value`, and `-ovalue`.
        let has =
            |name: &str| word.strip_prefix(name).is_some_and(|rest| rest.starts_with('=') || name == "-o");
        if DIVIDED.contains(&word.as_str()) {
            words.next();
        } else if !FLAGS.contains(&word.as_str()) && !DIVIDED.iter().any(|name| has(name)) {
            kept.push(word.clone());
        }
    }
    kept
}

impl Tasks {
    /// Names files by their whole paths: tasks of an Open Job Description run in folders of their own.
    fn name_whole_paths(&mut self) -> std::io::Result<()> {
        self.name = std::path::absolute(&self.name)?;
        for word in self.command.iter_mut().filter(|word| Path::new(word).is_file()) {
            *word = std::path::absolute(&*word)?.display().to_string();
        }
        Ok(())
    }

    /// The words of a task, given what stands for its frames or its seed.
    fn words(&self, checkpoint: f32, part: &str) -> Vec<String> {
        let (option, name) = match self.by {
            Division::Frames(_) => ("--frames", self.name.clone()),
            Division::Seeds(..) => ("--seed", of_seed(&self.name, part)),
        };
        let mut words = self.command.clone();
        words.extend([option.into(), part.into(), "-o".into(), name.display().to_string()]);
        words.extend(["--resume".into(), "--checkpoint".into(), checkpoint.to_string()]);
        if let Division::Seeds(..) = self.by {
            words.push("--film".into());
        }
        words
    }

    /// The words that put the films of all seeds together.
    fn merge(&self, count: u32, first: u32) -> Vec<String> {
        let films = (first..=first + (count - 1)).map(|seed| of_seed(&self.name, &seed.to_string()));
        let films = films.map(|exr| checkpoint::path(&exr).display().to_string());
        let start = ["merge".to_owned()].into_iter();
        start.chain(films).chain(["-o".into(), self.name.display().to_string()]).collect()
    }

    /// A script for `sbatch`: an array of tasks. One that is preempted leaves a checkpoint and is queued again.
    fn slurm(&self, checkpoint: f32) -> String {
        let title = quoted(&self.name.file_stem().unwrap_or_default().to_string_lossy());
        let (mut words, threads) = (self.words(checkpoint, PART), self.threads.unwrap_or(1));
        words.push("--quiet".into());
        let line = words.iter().map(|word| with_part(word)).collect::<Vec<_>>().join(" ");
        let (tasks, parts, last) = match &self.by {
            Division::Frames(frames) => {
                let table = frames.iter().enumerate().map(|(i, part)| format!("    {i}) part={part} ;;\n"));
                let table = format!("case $SLURM_ARRAY_TASK_ID in\n{}esac\n", table.collect::<String>());
                (format!("0-{}", frames.len() - 1), table, String::new())
            }
            Division::Seeds(count, first) => {
                let merge: Vec<String> = self.merge(*count, *first).iter().map(|word| quoted(word)).collect();
                let last = format!("# When all tasks are done:\n#   pmcip {}\n", merge.join(" "));
                (format!("{first}-{}", first + (count - 1)), "part=$SLURM_ARRAY_TASK_ID\n".into(), last)
            }
        };
        format!(
            "#!/bin/sh\n#SBATCH --job-name={title}\n#SBATCH --array={tasks}\n#SBATCH --requeue\n\
             #SBATCH --signal=TERM@60\n# Add what your site asks for: --time, --cpus-per-task, --mem, --partition.\n{last}\
             set -eu\n{parts}exec pmcip {line} --threads \"${{SLURM_CPUS_PER_TASK:-{threads}}}\"\n"
        )
    }

    /// An Open Job Description template (version 2023-09): one step of tasks, and for seeds one that merges.
    fn openjd(&self, checkpoint: f32) -> String {
        let script =
            |words: Vec<String>| json!({ "actions": { "onRun": { "command": "pmcip", "args": words } } });
        let (parameter, merge) = match &self.by {
            Division::Frames(frames) => (json!({ "name": "Part", "type": "STRING", "range": frames }), None),
            Division::Seeds(count, first) => {
                let range = format!("{first}-{}", first + (count - 1));
                (json!({ "name": "Part", "type": "INT", "range": range }), Some(self.merge(*count, *first)))
            }
        };
        let mut words = self.words(checkpoint, "{{Task.Param.Part}}");
        words.extend(["--progress".to_owned(), "openjd".to_owned()]);
        words.extend(self.threads.iter().flat_map(|threads| ["--threads".to_owned(), threads.to_string()]));
        let render = json!({
            "name": "Render",
            "parameterSpace": { "taskParameterDefinitions": [parameter] },
            "script": script(words),
        });
        let merge = merge.map(|words| {
            json!({ "name": "Merge", "dependencies": [{ "dependsOn": "Render" }], "script": script(words) })
        });
        let steps: Vec<Value> = std::iter::once(render).chain(merge).collect();
        let name = self.name.file_stem().unwrap_or_default().to_string_lossy();
        let job = json!({ "specificationVersion": "jobtemplate-2023-09", "name": name, "steps": steps });
        // Plain data with string keys: it cannot fail to become JSON.
        serde_json::to_string_pretty(&job).unwrap_or_default()
    }
}

/// The file of a seed: `name.exr` becomes `name.seed7.exr`.
fn of_seed(name: &Path, seed: &str) -> PathBuf {
    let extension = name.extension().unwrap_or_default().to_string_lossy().into_owned();
    name.with_extension(format!("seed{seed}.{extension}"))
}

/// A word as a shell reads it, its variable `part` where the word has [`PART`].
fn with_part(word: &str) -> String {
    let pieces = word.split(PART).map(|piece| if piece.is_empty() { String::new() } else { quoted(piece) });
    pieces.collect::<Vec<_>>().join("\"$part\"")
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./,:=+-".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}
