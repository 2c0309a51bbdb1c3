//! `farm`: the tasks of a queue, played by hand, make what one program makes.
#![cfg(unix)]

mod program;

use program::{failure, success};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

fn room() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = "[film]\nwidth = 24\nheight = 17\n[frames]\nfirst = 1\nlast = 7\n[camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\n\
        fov = 40\nkeys = [{ frame = 1, from = [0, 0, 5] }, { frame = 7, from = [1, 0, 5] }]\n\
        [[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 2\nmaterial = \"m\"\n\
        [[lights]]\ncenter = [0, 4, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 9, 9]\n[materials.m]\n";
    fs::write(folder.path().join("my room.toml"), scene).unwrap();
    folder
}

/// Runs the program in a folder; words may have blanks.
fn pmcip(folder: &Path, words: &[&str]) -> String {
    let done = Command::new(env!("CARGO_BIN_EXE_pmcip")).current_dir(folder).args(words).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

/// Runs a job script as Slurm runs a task of its array.
fn task(folder: &Path, script: &str, number: u32) {
    let program = Path::new(env!("CARGO_BIN_EXE_pmcip")).parent().unwrap();
    let path = std::env::join_paths([program, Path::new("/usr/bin"), Path::new("/bin")]).unwrap();
    let mut shell = Command::new("sh");
    shell.current_dir(folder).env("PATH", path).env("SLURM_ARRAY_TASK_ID", number.to_string());
    let done = shell.args(["-c", script]).output().unwrap();
    assert!(done.status.success(), "{script}\n{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn chunks_of_frames_are_those_of_one_run() {
    let [farm, alone] = [room(), room()];
    let render = ["render", "my room.toml", "--frames", "..", "--spp", "4", "-o", "it's.exr"];
    let script = pmcip(farm.path(), &[&["farm", "slurm", "--chunk", "3", "--"], &render[..]].concat());
    assert!(script.contains("#SBATCH --array=0-2\n") && script.contains("1) part=4-6 ;;"), "{script}");
    // In any order, and once more after a requeue.
    [2, 0, 1, 0].into_iter().for_each(|number| task(farm.path(), &script, number));
    pmcip(alone.path(), &render);
    for frame in 1..=7 {
        let [a, b] = [&farm, &alone]
            .map(|folder| fs::read(folder.path().join(format!("it's.{frame:04}.exr"))).unwrap());
        assert!(a == b, "frame {frame}");
    }
}

#[test]
fn seeds_of_a_frame_are_merged() {
    let room = room();
    let render =
        ["--", "render", "my room.toml", "--spp=4", "--seed=5", "-of.exr", "--quiet", "--threads", "2"];
    let script = pmcip(room.path(), &[&["farm", "slurm", "--seeds", "3"], &render[..]].concat());
    assert!(
        script.contains("#SBATCH --array=5-7\n") && script.contains("{SLURM_CPUS_PER_TASK:-2}"),
        "{script}"
    );
    (5..=7).for_each(|number| task(room.path(), &script, number));
    let merge = script.lines().find_map(|line| line.strip_prefix("#   pmcip ")).unwrap();
    assert!(success(room.path(), merge).contains("3 films, 4896 samples"));
    let job = pmcip(room.path(), &[&["farm", "openjd", "--seeds", "3"], &render[..]].concat());
    let job: Value = serde_json::from_str(&job).unwrap();
    assert_eq!(job["specificationVersion"], "jobtemplate-2023-09");
    let [step, last] = [&job["steps"][0], &job["steps"][1]];
    assert_eq!(step["parameterSpace"]["taskParameterDefinitions"][0]["range"], "5-7");
    let words = |step: &Value| -> Vec<String> {
        let words = step["script"]["actions"]["onRun"]["args"].as_array().unwrap();
        words.iter().map(|word| word.as_str().unwrap().replace("{{Task.Param.Part}}", "9")).collect()
    };
    let words_of_nine = words(step);
    let said = pmcip(room.path(), &words_of_nine.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(said.contains("openjd_progress: 0.0\n") && said.contains("openjd_progress: 100.0\n"), "{said}");
    assert!(room.path().join("f.seed9.film").exists());
    // Such tasks run in folders of their own.
    let here = format!("{}/", room.path().canonicalize().unwrap().display());
    assert_eq!(words(last).join(" ").replace(&here, ""), merge);
}

#[test]
fn what_cannot_be_divided_is_refused() {
    let room = room();
    fs::rename(room.path().join("my room.toml"), room.path().join("room.toml")).unwrap();
    failure(room.path(), "farm slurm -- render room.toml", 2, "one frame is divided by --seeds");
    failure(room.path(), "farm slurm --seeds 2 -- render room.toml --frames ..", 2, "give no --frames");
    failure(room.path(), "farm slurm -- render room.toml --frames .. --video w.mp4", 2, "are of a whole run");
    failure(room.path(), "farm slurm -- info room.toml", 2, "only `render` can be divided");
    failure(room.path(), "farm slurm -- render room.toml --sppp 4", 2, "unexpected argument '--sppp'");
    failure(
        room.path(),
        "farm slurm --seeds 9 -- render room.toml --seed 4294967290",
        2,
        "the last seed is beyond",
    );
}

/// A real queue: minutes, and root. Says why where it cannot run.
#[test]
#[ignore = "starts the daemons of Slurm"]
fn slurm_runs_the_arrays() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support/slurm.sh");
    let done = Command::new("sh").arg(script).arg(env!("CARGO_BIN_EXE_pmcip")).output().unwrap();
    print!("{}", String::from_utf8_lossy(&done.stdout));
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}
