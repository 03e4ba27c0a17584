"""A client of OPC UA that does what standard input asks for, a JSON object a line, and prints a JSON object for each.

    opcua.py URL [NAME FOLDER]

With a name and a folder as `coaxle opcua --certificates` makes it: signed and encrypted.
"""

import asyncio
import json
import sys
import time
from datetime import timezone

from asyncua import Client, ua
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256

NODES = "urn:coaxle:nodes"


def show(answer):
    print(json.dumps(answer, default=str), flush=True)


def variant(value):
    """{"double": "nan"} and the like are typed; the others are what JSON says."""
    if isinstance(value, dict):
        kind, value = next(iter(value.items()))
        if kind == "double":
            return ua.Variant(float(value), ua.VariantType.Double)
        return ua.Variant(value, ua.VariantType[kind])
    if value is None:
        return ua.Variant(None, ua.VariantType.Null)
    if isinstance(value, bool):
        return ua.Variant(value, ua.VariantType.Boolean)
    if isinstance(value, (int, float)):
        return ua.Variant(float(value), ua.VariantType.Double)
    return ua.Variant(value, ua.VariantType.String)


class Handler:
    """Prints what a subscription brings."""

    def datachange_notification(self, node, value, data):
        source = data.monitored_item.Value.SourceTimestamp
        show({"changed": node.nodeid.Identifier, "value": value, "source": source and source.timestamp()})

    def event_notification(self, event):
        show({"event": event.Message.Text, "severity": event.Severity, "source": event.SourceName})

    def status_change_notification(self, status):
        pass


class Actions:
    def __init__(self, client, namespace):
        self.client, self.namespace, self.subscription = client, namespace, None

    def node(self, path):
        return self.client.get_node(ua.NodeId(path, self.namespace))

    async def browse(self, path):
        children = await self.node(path).get_children()
        return sorted([child.nodeid.Identifier for child in children])

    async def read(self, path):
        node = self.node(path)
        data = await node.read_data_value(raise_on_bad_status=False)
        answer = {"value": data.Value and data.Value.Value, "status": ua.status_codes.get_name_and_doc(data.StatusCode.value)[0]}
        if data.SourceTimestamp:
            source = data.SourceTimestamp.replace(tzinfo=timezone.utc).timestamp()
            answer |= {"source": source, "age": time.time() - source}
        try:
            unit = await (await node.get_child("0:EngineeringUnits")).read_value()
            answer["unit"] = [unit.UnitId, unit.DisplayName.Text, unit.NamespaceUri]
        except ua.UaError:
            pass
        return answer

    async def arguments(self, path):
        inputs = await (await self.node(path).get_child("0:InputArguments")).read_value()
        return [argument.Name for argument in inputs]

    async def call(self, path, arguments):
        request = ua.CallMethodRequest()
        request.ObjectId = self.node(path.split(":")[0]).nodeid
        request.MethodId = self.node(path).nodeid
        request.InputArguments = [variant(value) for value in arguments]
        result = (await self.client.uaclient.call([request]))[0]
        name = lambda status: ua.status_codes.get_name_and_doc(status.value)[0]
        outputs = [output.Value for output in result.OutputArguments or []]
        names = ["accepted", "outcome", "text", "code", "job", "response"]
        return {
            "status": name(result.StatusCode),
            "arguments": [name(status) for status in result.InputArgumentResults or []],
            **dict(zip(names, outputs)),
        }

    async def subscribe(self, path):
        self.subscription = self.subscription or await self.client.create_subscription(100, Handler())
        await self.subscription.subscribe_data_change(self.node(path))
        return path

    async def events(self):
        self.subscription = self.subscription or await self.client.create_subscription(100, Handler())
        await self.subscription.subscribe_events(queuesize=100)
        return "events"


async def main(url, name=None, folder=None):
    client = Client(url, timeout=30)
    if name is not None:
        client.application_uri = f"urn:coaxle:opcua:{name}"
        await client.set_security(
            SecurityPolicyBasic256Sha256,
            f"{folder}/cert.der",
            f"{folder}/key.pem",
            server_certificate=f"{folder}/server.der",
        )
    try:
        await client.connect()
    except Exception as error:
        show({"refused": f"{type(error).__name__}: {error}"})
        return
    actions = Actions(client, await client.get_namespace_index(NODES))
    show({"connected": [endpoint.SecurityPolicyUri for endpoint in await client.get_endpoints()]})
    loop = asyncio.get_running_loop()
    while line := await loop.run_in_executor(None, sys.stdin.readline):
        request = json.loads(line)
        action = request.pop("do")
        try:
            show({"done": await getattr(actions, action)(**request)})
        except Exception as error:
            show({"failed": f"{type(error).__name__}: {error}"})
    await client.disconnect()


asyncio.run(main(*sys.argv[1:]))
