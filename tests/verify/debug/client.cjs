// Drives rcx debug with the DebugClient of @vscode/debugadapter-testsupport, which VS Code's own
// adapters are tested with. Arguments: the port, its token, the program. Prints what it saw, as JSON.
const { DebugClient } = require("@vscode/debugadapter-testsupport");

async function main(port, token, program) {
  const client = new DebugClient("none", "none", "rcx");
  await client.start(port);
  const seen = {};
  await Promise.all([
    client.launch({ token, sources: [program], for: "1s" }),
    client.waitForEvent("initialized").then(async () => {
      await client.setBreakpointsRequest({
        source: { path: program },
        breakpoints: [{ line: 54, condition: "Doubled = 6" }],
      });
      await client.configurationDoneRequest();
    }),
    client.assertStoppedLocation("breakpoint", { path: program, line: 55 }).then((found) => {
      seen.stack = found.body.stackFrames.map((one) => one.name);
    }),
  ]);
  const frame = async () => (await client.stackTraceRequest({ threadId: 1 })).body.stackFrames[0];
  const value = async (expression) => {
    const asked = { expression, frameId: (await frame()).id, context: "watch" };
    return (await client.evaluateRequest(asked)).body.result;
  };
  seen.lamp = await value("Lamp");
  const moved = async (request) => {
    await Promise.all([request, client.waitForEvent("stopped")]);
    return (await frame()).line;
  };
  seen.next = await moved(client.nextRequest({ threadId: 1 }));
  seen.back = await moved(client.stepBackRequest({ threadId: 1 }));
  seen.in = await moved(client.stepInRequest({ threadId: 1 }));
  const scopes = (await client.scopesRequest({ frameId: (await frame()).id })).body.scopes;
  seen.scopes = scopes.map((one) => one.name);
  const locals = scopes.find((one) => one.name === "Variables").variablesReference;
  const set = { variablesReference: locals, name: "Doubled", value: "12" };
  seen.set = (await client.setVariableRequest(set)).body.value;
  seen.start = await moved(client.reverseContinueRequest({ threadId: 1 }));
  const first = await value("C.Value");
  seen.first = first;
  await Promise.all([
    client.setBreakpointsRequest({ source: { path: program }, breakpoints: [] }),
    client.continueRequest({ threadId: 1 }),
    client.waitForEvent("stopped"),
  ]);
  seen.end = await value("C.Value");
  await Promise.all([
    client.continueRequest({ threadId: 1 }),
    client.waitForEvent("terminated"),
  ]);
  await client.disconnectRequest();
  console.log(JSON.stringify(seen));
}

main(Number(process.argv[2]), process.argv[3], process.argv[4]).then(
  () => process.exit(0),
  (error) => {
    console.error(error);
    process.exit(1);
  },
);
