// Tells VS Code how to start `rcx debug` and `rcx lsp`. What they show comes from there.
const path = require("path");
const vscode = require("vscode");

let client;

function setting(name) {
  return vscode.workspace.getConfiguration("rcx").get(name);
}

function activate(context) {
  context.subscriptions.push(
    vscode.debug.registerDebugAdapterDescriptorFactory("rcx", {
      createDebugAdapterDescriptor() {
        return new vscode.DebugAdapterExecutable(setting("command"), ["debug"]);
      },
    }),
  );
  return startLanguageServer(context);
}

// Starts the language server. The debugger also works without the package of its client.
async function startLanguageServer(context) {
  let languageclient;
  try {
    languageclient = require("vscode-languageclient/node");
  } catch {
    const folder = path.resolve(context.extensionPath);
    vscode.window.showWarningMessage(
      `To see mistakes while you type, run "npm install" in ${folder}, then start VS Code again.`,
    );
    return;
  }
  const names = ["files", "lib", "for", "dialect", "replace", "device", "pause"];
  const given = Object.fromEntries(
    names.map((name) => [name, setting(name)]).filter(([, value]) => value !== "" && value?.length !== 0),
  );
  client = new languageclient.LanguageClient(
    "rcx",
    "rcx lsp",
    { command: setting("command"), args: ["lsp"] },
    {
      documentSelector: [{ scheme: "file", language: "structured-text" }, {
        scheme: "file",
        pattern: "**/*.{TcPOU,TcDUT,TcGVL,TcIO}",
      }],
      initializationOptions: given,
      synchronize: {
        fileEvents: vscode.workspace.createFileSystemWatcher(
          "**/*.{st,plcproj,TcPOU,TcDUT,TcGVL,TcIO,TcTTO}",
        ),
      },
    },
  );
  try {
    await client.start();
  } catch (error) {
    vscode.window.showErrorMessage(`${setting("command")} lsp does not start: ${error.message}`);
  }
}

function deactivate() {
  return client?.stop();
}

module.exports = { activate, deactivate };
