"""A network between two programs that can be cut, silent, closed or slow; bytes keep their order."""

import asyncio


class Link:
    """Leads from a port of its own (`port`) on the loopback interface to another."""

    def __init__(self, target):
        self.target = target
        self.port = 0
        self.delay_s = 0.0  # of each piece
        self._closed = False
        self._passable = asyncio.Event()
        self._passable.set()
        self._writers = set()
        self._server = None

    async def open(self):
        self._server = await asyncio.start_server(self._carry, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]

    def cut(self):
        """Ends every connection at once."""
        for writer in self._writers:
            writer.transport.abort()

    def hold(self):
        """From now on nothing arrives; connections stay, and new ones are accepted."""
        self._passable.clear()

    def close(self):
        """Ends every connection, and new ones as soon as they are made."""
        self._closed = True
        self.cut()

    def mend(self):
        self._closed = False
        self.delay_s = 0.0
        self._passable.set()

    async def _carry(self, reader, writer):
        writers = [writer]
        self._writers.add(writer)
        try:
            if self._closed:
                return
            other_reader, other_writer = await asyncio.open_connection("127.0.0.1", self.target)
            self._writers.add(other_writer)
            writers.append(other_writer)
            ways = [
                asyncio.create_task(self._pass_on(reader, other_writer)),
                asyncio.create_task(self._pass_on(other_reader, writer)),
            ]
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)
        except OSError:
            pass  # nobody listens there now
        finally:
            for each in writers:
                self._writers.discard(each)
                each.transport.abort()

    async def _pass_on(self, reader, writer):
        try:
            while piece := await reader.read(65536):
                if self.delay_s:
                    await asyncio.sleep(self.delay_s)
                await self._passable.wait()
                writer.write(piece)
                await writer.drain()
        except OSError:
            pass
