// Tells VS Code how to start `rcx debug`. What it shows comes from there.
const vscode = require("vscode");

function activate(context) {
  context.subscriptions.push(
    vscode.debug.registerDebugAdapterDescriptorFactory("rcx", {
      createDebugAdapterDescriptor() {
        const command = vscode.workspace.getConfiguration("rcx").get("command", "rcx");
        return new vscode.DebugAdapterExecutable(command, ["debug"]);
      },
    }),
  );
}

module.exports = { activate, deactivate() {} };
