//! `hopes completions` and `hopes man`: scripts that shells can read, a page for every command.

use std::process::{Command, Stdio};

use crate::common::process::hopes;

/// The names of all commands.
fn commands() -> Vec<String> {
    let help = hopes("--help").runs().text();
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = lines.filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
    names.filter(|&name| name != "help").map(str::to_owned).collect()
}

#[test]
fn every_shell_gets_a_script_with_all_commands() {
    let commands = commands();
    assert!(commands.len() >= 15, "{commands:?}");
    for (shell, option) in [
        ("bash", "--panels"),
        ("zsh", "--panels"),
        ("fish", "panels"),
        ("elvish", "--panels"),
        ("powershell", "--panels"),
    ] {
        let script = hopes("completions").with(shell).runs().text();
        assert!(script.contains(option), "{shell}");
        for command in &commands {
            assert!(script.contains(command.as_str()), "{shell}: {command}");
        }
    }
    hopes("completions tcsh").runs().fails(2, &["bash", "fish", "zsh"]);
}

/// The shell itself completes a word by the script.
#[test]
fn bash_completes_by_its_script() {
    let script = hopes("completions bash").runs().out();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hopes.bash");
    std::fs::write(&path, script).unwrap();
    let complete = "source \"$1\"; COMP_WORDS=(hopes compute --pan); COMP_CWORD=2; _hopes hopes --pan compute; echo \"${COMPREPLY[@]}\"";
    let bash = Command::new("bash").args(["-c", complete, "bash"]).arg(&path).stdin(Stdio::null()).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&bash.stdout).trim(), "--panels", "{}", String::from_utf8_lossy(&bash.stderr));
}

#[test]
fn every_command_has_a_page_of_the_manual() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("share/man1");
    hopes("man").with(&pages).runs().out();
    let page = |name: &str| std::fs::read_to_string(pages.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(page("hopes.1").starts_with(".ie"), "it is roff");
    for command in commands() {
        let page = page(&format!("hopes-{command}.1"));
        assert!(page.contains(".TH") && page.contains("hopes"), "{command}");
        assert!(page.contains("Examples:"), "hopes-{command}.1 has its examples");
    }
    // The same program writes the same pages.
    let first = page("hopes-compute.1");
    assert!(first.contains("panels") && !first.contains(folder.path().to_str().unwrap()));
    hopes("man").with(&pages).runs().out();
    assert_eq!(page("hopes-compute.1"), first);
    hopes("man /proc/none").runs().fails(1, &["cannot make the folder /proc/none"]);
}
