// Serves the built pages with the made-up home, for looking at: npm run try [-- PORT].
import { StandInServer } from './stand_in_server';

const server = new StandInServer(process.env['ROOMWISE_WEB'] ?? '');
await server.start(Number(process.argv[2] ?? 8080));
console.log(`${server.url}/pair (code ${server.state.code}); roles: device, and helper after POST /api/codes`);
