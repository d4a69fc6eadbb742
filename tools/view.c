/* SPDX-License-Identifier: MIT */
/* pellucid view: the viewer. Listens and shows the page before the volume is read, so that the one waits for the other as little as can be.
 */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "commands.h"
#include "downloads.h"
#include "scene_arguments.h"
#include "server.h"

extern char **environ;

struct values {
    struct scene_arguments scene;
    char listen[PEL_OPTION_TEXT_SIZE], record[PEL_OPTION_TEXT_SIZE];
    int port;
    bool open;
    double max_upload, budget;
};

#define FIELD(name) offsetof(struct values, name)
static const struct pel_option rows[] = {
    { "open", "Open", "Open the page in the browser (xdg-open); its address is printed in any case", PEL_OPTION_BOOL, FIELD(open), 0, 0,
      "true", NULL, NULL },
    { "port", "Port", "Port to listen on; 0 is a free one", PEL_OPTION_INT, FIELD(port), 0, 65535, "0", NULL, NULL },
    { "listen", "Listen",
      "Address to listen on. Beyond 127.0.0.1 whoever reads the traffic sees the address with its token: better tunnel the port (ssh -L)",
      PEL_OPTION_TEXT, FIELD(listen), 0, 0, "127.0.0.1", NULL, NULL },
    { "max-upload", "Largest upload", "Of the files dropped on the page at once; 0 takes none", PEL_OPTION_DOUBLE, FIELD(max_upload), 0,
      1e9, "4096", NULL, "MB" },
    { "budget", "Budget", "Time for a picture while things move: smaller pictures and longer steps keep to it", PEL_OPTION_DOUBLE,
      FIELD(budget), 1, 10000, "33", NULL, "ms" },
    { "record", "Record", "Write every command into this file, for `pellucid replay`", PEL_OPTION_TEXT, FIELD(record), 0, 0, NULL, NULL,
      NULL },
    { NULL },
};
static const struct option_extra extras[] = { { "listen", 0, "ADDRESS", NULL, false }, { "record", 0, "FILE", NULL, false }, { NULL } };
static const struct option_group groups[] = { SCENE_OPTION_GROUPS, { "Server", rows, extras }, { NULL } };

struct first {
    const struct arguments *arguments;
    const struct values *values;
    const char *path; /* or NULL: the scene file's */
    struct pel_error error;
    atomic_bool failed, done; /* done: read, or failed */
};

/* So long, in looks of LOOK_MS, the address waits for the first file: what is wrong with a file is mostly known at once, and no browser is
 * to be led to a viewer that ends. Reading a large one goes on beside the page. */
enum { LOOKS = 100, LOOK_MS = 5 };

static bool any_given(const struct arguments *arguments, const struct pel_option *table)
{
    for (; table->name; table++)
        if (arguments_given(arguments, table->name))
            return true;
    return false;
}

static bool is_folder(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 && S_ISDIR(st.st_mode);
}

/* What the flags and files say, read by the session's thread. */
static bool open_first(void *user, struct session_opened *opened, const struct pel_progress *progress, struct pel_error *error)
{
    struct first *first = user;
    const struct scene_arguments *values = &first->values->scene;
    static struct loaded_scene loaded;
    struct progress bar;
    progress_init(&bar, true);
    bar.also = *progress;
    const char *path = first->path ? first->path : values->scene;
    bool fine = session_is_text(path) || tool_fail(error, PEL_ERROR_ARGUMENT, "%.300s: " SESSION_NO_TEXT, path);
    if (!fine || !scene_load(&loaded, first->arguments, values, first->path, &bar, error)) {
        first->error = *error;
        if (first->path && is_folder(first->path) && error->code == PEL_ERROR_FORMAT)
            tool_note("%s; choose a file of it in the page", error->message);
        else
            atomic_store(&first->failed, true);
        atomic_store(&first->done, true);
        return false;
    }
    opened->volume = loaded.volume;
    opened->scene = loaded.scene;
    opened->info = loaded.info;
    opened->device = loaded.device;
    opened->fit_camera = !values->scene[0] && !any_given(first->arguments, pel_camera_options) && !any_given(first->arguments, move_rows);
    if (!values->scene[0] && !arguments_given(first->arguments, "refine"))
        opened->scene.render.refine = SESSION_REFINE;
    atomic_store(&first->done, true);
    return true;
}

static bool should_stop(void *user)
{
    const struct first *first = user;
    return interruption() || atomic_load(&first->failed);
}

static void wait_for_first(struct first *first)
{
    for (int i = 0; i < LOOKS && !atomic_load(&first->done) && !interruption(); i++)
        nanosleep(&(struct timespec) { 0, LOOK_MS * 1000000L }, NULL);
}

/* Where a browser may read a file of this user's. A snap's sees none but those of the home folder that are not hidden. */
static const char *folder_for_browser(void)
{
    const char *home = getenv("HOME"), *run = getenv("XDG_RUNTIME_DIR");
    char snaps[PEL_OPTION_TEXT_SIZE];
    if (home && snprintf(snaps, sizeof snaps, "%s/snap", home) < (int)sizeof snaps && access(snaps, F_OK) == 0)
        return home;
    return run && run[0] && access(run, W_OK) == 0 ? run : temporary_folder();
}

/* A page that leads to the viewer's and that this user alone can read: the words of a command line, and so its token, anybody on the
 * machine can. */
static bool write_leading_page(const char *address, char path[PEL_OPTION_TEXT_SIZE])
{
    int length = snprintf(path, PEL_OPTION_TEXT_SIZE, "%s/pellucid-view-XXXXXX.html", folder_for_browser());
    int fd = length < PEL_OPTION_TEXT_SIZE ? mkostemps(path, (int)strlen(".html"), O_CLOEXEC) : -1; /* 0600 */
    if (fd < 0)
        return false;
    bool fine = dprintf(fd,
                        "<!DOCTYPE html><meta charset=\"utf-8\"><meta name=\"referrer\" content=\"no-referrer\"><title>Pellucid</title>"
                        "<meta http-equiv=\"refresh\" content=\"0; url=%s\"><a href=\"%s\">The viewer</a>\n",
                        address, address) > 0;
    if (close(fd) == 0 && fine)
        return true;
    unlink(path);
    return false;
}

/* `page` gets the path of a file to be removed at the end, or "". */
static void open_browser(const char *address, char page[PEL_OPTION_TEXT_SIZE])
{
    char *argv[] = { "xdg-open", page, NULL };
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t defaults;
    pid_t pid;
    if (!write_leading_page(address, page)) {
        page[0] = 0;
        tool_note("no browser is started, for no file can be made in %s: %s; open the address above in one", folder_for_browser(),
                  strerror(errno));
        return;
    }
    signal(SIGCHLD, SIG_IGN); /* nobody waits for it */
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_init(&attributes);
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGCHLD);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    int failure = posix_spawnp(&pid, argv[0], &actions, &attributes, argv, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (failure)
        tool_note("no browser could be started (xdg-open: %s); open the address above in one", strerror(failure));
}

/* Serves until it is interrupted, or the first file could not be opened. */
static bool serve(const struct values *values, struct first *first, char **paths, FILE *record, struct pel_error *error)
{
    const struct server_params where = { values->listen, values->port, (uint64_t)(values->max_upload * 1e6) };
    struct server *server = server_create(&where, error);
    char page[PEL_OPTION_TEXT_SIZE] = "";
    if (!server)
        return false;
    const struct session_params params = {
        .user = server,
        .frame = server_frame,
        .event = server_event,
        .wanted = server_wanted,
        .open = open_first,
        .open_user = first,
        .paths = (const char *const *)paths,
        .threads = values->scene.threads,
        .budget_ms = values->budget,
        .list_devices = true,
        .gpu_memory = (uint64_t)(values->scene.gpu_memory * 1e6),
        .record = record,
    };
    struct session *session = session_create(&params, error);
    if (session)
        wait_for_first(first);
    if (session && !should_stop(first)) {
        printf("%s\n", server_address(server));
        fflush(stdout);
        if (values->open)
            open_browser(server_address(server), page);
        server_run(server, session, should_stop, first);
        if (page[0])
            unlink(page);
    }
    session_destroy(session);
    server_destroy(server);
    if (session && atomic_load(&first->failed) && !interruption()) {
        *error = first->error;
        return false;
    }
    return session;
}

static bool is_scene_file(const char *path)
{
    size_t length = strlen(path);
    return length > 5 && strcmp(path + length - 5, ".json") == 0;
}

static int run(const struct command *command, int argc, char **argv)
{
    static struct values values;
    struct arguments arguments = { .command = command };
    struct first first = { .arguments = &arguments, .values = &values };
    struct pel_error error = PEL_ERROR_INIT;
    struct stat st;
    char *none[] = { NULL };
    scene_arguments_attach(&arguments, &values.scene);
    arguments.objects[GROUP_OWN] = &values;
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 1000);
    if (status >= 0)
        return status;
    char **paths = arguments.operand_count ? arguments.operands : none;
    first.path = paths[0];
    if (first.path && !values.scene.scene[0] && is_scene_file(first.path)) {
        snprintf(values.scene.scene, sizeof values.scene.scene, "%s", first.path);
        first.path = NULL;
    }
    if (!first.path && !values.scene.scene[0])
        tool_fail(&error, PEL_ERROR_ARGUMENT, "view: a file name is missing; usage: pellucid view %s", command->usage);
    for (int i = 0; i < arguments.operand_count && !error.code; i++)
        if (stat(paths[i], &st) != 0)
            tool_fail(&error, PEL_ERROR_IO, "%.300s: %s", paths[i], strerror(errno));
        else if (!S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode)) /* a pipe could keep the viewer waiting for ever */
            tool_fail(&error, PEL_ERROR_IO, "%.300s: it is neither a file nor a folder", paths[i]);
    if (error.code)
        return tool_report(&error);
    FILE *record = values.record[0] ? fopen(values.record, "we") : NULL;
    if (values.record[0] && !record) {
        tool_fail(&error, PEL_ERROR_IO, "--record %.300s: %s", values.record, strerror(errno));
        return tool_report(&error);
    }
    bool fine = serve(&values, &first, paths, record, &error);
    bool whole = !record || !ferror(record);
    if ((record && fclose(record) != 0) || !whole)
        fine = fine &&
               tool_fail(&error, PEL_ERROR_IO, "--record %.300s: it could not be written to its end; is the disk full?", values.record);
    return tool_finish_stdout(fine ? EXIT_FINE : tool_report(&error));
}

const struct command command_view = {
    .name = "view",
    .summary = "Turn a volume under your hand, in a browser",
    .usage = "FILE... [options]",
    .description = "Prints the address of a page and opens it in the browser. The first FILE is shown: a volume, a folder with a DICOM "
                   "series or TIFF slices, or "
                   "a scene file; of a folder that holds no such slices the page shows what can be opened. The others, and what lies below "
                   "those that are folders, can be opened from the page; nothing else can.\n\n"
                   "On another machine: pellucid view FILE --no-open --port 8080 there, ssh -L 8080:127.0.0.1:8080 here, and the address "
                   "that it printed. "
                   "Ctrl-C ends it.",
    .examples = "  pellucid view scan.nii.gz\n"
                "  pellucid view head.nrrd data/ --isovalue 90\n"
                "  pellucid view scene.json --no-open --port 8080\n",
    .groups = groups,
    .draws = true,
    .run = run,
};
