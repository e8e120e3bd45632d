/* A simulator's side of `olp controller`, in C: connects, gives three targets, prints every step.
 *
 *     cc -O2 -o controller_client controller_client.c
 *     ./controller_client 40115
 *
 * The answers are one JSON object per line. A simulator would hand them to its JSON reader; here the few numbers
 * that are shown are picked out by hand, so that the example needs nothing but the C library (POSIX sockets).
 */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define LONGEST 65536

static FILE *from_controller;
static int connection;

/* Sends one request and reads its answer. Ends the program when the controller says no. */
static char *ask(const char *request)
{
    static char answer[LONGEST], line[LONGEST];
    /* In one piece: a line sent in two would wait for the network's acknowledgement of the first. */
    int length = snprintf(line, sizeof line, "%s\n", request);
    if (write(connection, line, (size_t)length) != length || !fgets(answer, sizeof answer, from_controller)) {
        fprintf(stderr, "the controller has gone\n");
        exit(2);
    }
    if (!strstr(answer, "\"ok\": true")) {
        fprintf(stderr, "%s", answer);
        exit(2);
    }
    return answer;
}

/* The number behind a key, 0 when the answer has no such key. */
static double number(const char *answer, const char *key)
{
    const char *place = strstr(answer, key);
    return place ? strtod(place + strlen(key), NULL) : 0.0;
}

int main(int count, char **arguments)
{
    static const char *targets[] = {
        "{\"do\": \"target\", \"path\": \"joint\", \"speed_pct\": 40, \"zone_mm\": 0,"
        " \"joints_deg\": [12.5, 7.5, -3.5, 4.5, -57.5, 8.5]}",
        "{\"do\": \"target\", \"path\": \"joint\", \"speed_pct\": 25, \"zone_mm\": 25,"
        " \"joints_deg\": [-8.5, 11.5, 2.5, -6.5, -63.5, 21.5]}",
        "{\"do\": \"wait\", \"seconds\": 0.25}",
    };
    size_t given = 0;
    int steps = 0;
    struct sockaddr_in address = {0};

    address.sin_family = AF_INET;
    address.sin_port = htons((unsigned short)(count > 1 ? atoi(arguments[1]) : 40115));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connection = socket(AF_INET, SOCK_STREAM, 0);
    if (connection < 0 || connect(connection, (struct sockaddr *)&address, sizeof address) != 0) {
        fprintf(stderr, "no controller is listening: start `olp controller`\n");
        return 2;
    }
    from_controller = fdopen(dup(connection), "r");

    ask("{\"do\": \"robot\", \"name\": \"yaskawa/ma2010\", \"cycle_s\": 0.004}");
    ask("{\"do\": \"tool\", \"pose_mm_deg\": [12, -7, 310, 5.7, 29.8, 11.5]}");
    ask("{\"do\": \"position\", \"joints_deg\": [11.5, 5.5, -8.5, 12.5, -61.5, 20.5]}");
    for (;;) {
        const char *answer = ask("{\"do\": \"step\"}");
        if (number(answer, "\"elapsed_s\": ") > 0) {
            steps++;
            printf("%8.4f s  %8.2f mm/s\n", number(answer, "\"t_s\": "), number(answer, "\"speed_mm_s\": "));
        }
        if (strstr(answer, "{\"ok\": true, \"state\": \"done\""))
            break;
        if (!strstr(answer, "{\"ok\": true, \"state\": \"moving\"")) {
            if (given < sizeof targets / sizeof *targets)
                ask(targets[given++]);
            else
                ask("{\"do\": \"end\"}");
        }
    }
    printf("%d steps\n", steps);
    ask("{\"do\": \"bye\"}");
    return 0;
}
