/* A host of `romrun FILE --serve udp:PORT` in C99 with POSIX sockets; the packets are those of docs/udp.md. For little-endian
 * machines with IEEE doubles.
 *
 *   cc -std=c99 client.c -o client && ./client PORT [STEPS]
 *
 * does what client.py does, and prints the same digits. */
#define _POSIX_C_SOURCE 200112L
#include <arpa/inet.h>
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

enum { HELLO = 1, NAME, STEP, READ, RESET, SNAPSHOT, RESTORE, REPLY = 0x8000, ERROR_REPLY = 0xffff };
enum { DEAD = 0, BODY = 1 };
enum { HEADER = 24, TRIES = 10 };

static int connection;
static uint32_t session, sequence;
static unsigned char reply[65536];

static uint32_t crc32(const unsigned char *bytes, size_t n)
{
    uint32_t crc = 0xffffffffu;
    size_t i;
    int bit;
    for (i = 0; i < n; i++) {
        crc ^= bytes[i];
        for (bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void fail(const char *what)
{
    fprintf(stderr, "%s\n", what);
    exit(1);
}

/* One exchange; a request without a reply is sent again under the same number, and not done twice. Returns the payload. */
static const unsigned char *ask(uint16_t kind, const void *payload, uint32_t length)
{
    static unsigned char packet[65536];
    const uint16_t version = 1;
    const uint32_t zero = 0;
    const struct timespec pause = { 0, 200000000 };
    uint32_t crc;
    int try;

    sequence++;
    memcpy(packet, "ROMU", 4);
    memcpy(packet + 4, &version, 2);
    memcpy(packet + 6, &kind, 2);
    memcpy(packet + 8, &session, 4);
    memcpy(packet + 12, &sequence, 4);
    memcpy(packet + 16, &length, 4);
    memcpy(packet + 20, &zero, 4);
    if (length > 0)
        memcpy(packet + HEADER, payload, length);
    crc = crc32(packet, HEADER + length);
    memcpy(packet + HEADER + length, &crc, 4);

    for (try = 0; try < TRIES; try++) {
        ssize_t n;
        if (send(connection, packet, HEADER + length + 4, 0) < 0 && errno != ECONNREFUSED)
            fail("cannot send");
        errno = 0;
        while ((n = recv(connection, reply, sizeof reply, 0)) >= HEADER + 4) {
            uint16_t found;
            if (memcmp(reply + 8, packet + 8, 8) != 0)
                continue; /* to what was asked before */
            memcpy(&crc, reply + n - 4, 4);
            if (crc != crc32(reply, (size_t)n - 4))
                continue;
            memcpy(&found, reply + 6, 2);
            if (found == ERROR_REPLY) {
                reply[n - 4] = 0;
                fail((const char *)reply + HEADER + 8);
            }
            return reply + HEADER;
        }
        if (errno == ECONNREFUSED)
            nanosleep(&pause, NULL); /* nobody listens there yet */
    }
    fail("the server does not answer");
    return NULL;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int argc, char **argv)
{
    struct sockaddr_in server;
    struct timeval patience = { 0, 200000 };
    uint32_t counts[6];
    uint32_t request[2 + 2 + 12] = { 1, 1, 0, BODY }; /* one step, one wrench: point 0, in A */
    double state[20], wrench[6] = { 0 }, dt, *took;
    const unsigned char *payload;
    int i, k, steps;

    if (argc < 2)
        fail("usage: client PORT [STEPS]");
    steps = argc > 2 ? atoi(argv[2]) : 1000;
    took = malloc(sizeof *took * (size_t)(steps > 0 ? steps : 1));
    memset(&server, 0, sizeof server);
    server.sin_family = AF_INET;
    server.sin_port = htons((uint16_t)atoi(argv[1]));
    server.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connection = socket(AF_INET, SOCK_DGRAM, 0);
    if (took == NULL || connection < 0 || connect(connection, (struct sockaddr *)&server, sizeof server) != 0)
        fail("no socket");
    setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    session = (uint32_t)time(NULL) ^ (uint32_t)getpid() << 16;

    payload = ask(HELLO, NULL, 0);
    memcpy(counts, payload, sizeof counts);
    memcpy(&dt, payload + sizeof counts, sizeof dt);
    {
        const uint32_t model[2] = { 0, 0 };
        uint32_t length;
        payload = ask(NAME, model, sizeof model);
        memcpy(&length, reply + 16, 4);
        printf("%.*s: %u modes, %u points, dt = %g s\n", (int)length, (const char *)payload, (unsigned)counts[1],
               (unsigned)counts[0], dt);
    }
    memcpy(state, ask(RESET, NULL, 0) + 8, sizeof state);
    for (i = 0; i < steps; i++) {
        struct timespec start, end;
        for (k = 0; k < 3; k++)
            wrench[3 + k] = -20 * state[13 + k]; /* angular velocity of A in A */
        memcpy(request + 4, wrench, sizeof wrench);
        clock_gettime(CLOCK_MONOTONIC, &start);
        payload = ask(STEP, request, sizeof request);
        clock_gettime(CLOCK_MONOTONIC, &end);
        memcpy(state, payload + 8, sizeof state);
        took[i] = (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
    }
    printf("t = %.6f s, r_G = (%.9e, %.9e, %.9e) m\n", state[0], state[1], state[2], state[3]);
    if (steps > 0) {
        qsort(took, (size_t)steps, sizeof *took, by_size);
        fprintf(stderr, "exchange: median %.0f us, longest %.0f us\n", 1e6 * took[steps / 2], 1e6 * took[steps - 1]);
    }
    free(took);
    close(connection);
    return 0;
}
