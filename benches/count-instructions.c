/* A plugin for qemu's user-mode emulation: how many instructions the emulated program executes, on standard error at
 * its end.
 *
 *   cc -O2 -shared -fPIC -o count-instructions.so count-instructions.c
 *   qemu-arm -plugin ./count-instructions.so PROGRAM
 *
 * With BLOCKS=FILE in the environment, also a line for each block of code: its address, its instructions, how often it
 * ran.
 * What qemu provides (version 1 of its plugin interface) is declared here, as Debian has no package with its header. */

#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

typedef uint64_t plugin_id;
struct qemu_plugin_tb;

extern void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, void (*)(plugin_id, struct qemu_plugin_tb *));
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
extern uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb *);
extern void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb *, int operation, void *, uint64_t);
extern void qemu_plugin_register_atexit_cb(plugin_id, void (*)(plugin_id, void *), void *);

int qemu_plugin_version = 1;

enum { ADD = 0 };

struct block {
    uint64_t address, instructions, runs;
    struct block *next;
};

static struct block *blocks;

static void translated(plugin_id id, struct qemu_plugin_tb *code) {
    (void)id;
    struct block *block = calloc(1, sizeof *block);
    if (!block)
        abort();
    block->address = qemu_plugin_tb_vaddr(code);
    block->instructions = qemu_plugin_tb_n_insns(code);
    block->next = blocks;
    blocks = block;
    qemu_plugin_register_vcpu_tb_exec_inline(code, ADD, &block->runs, 1);
}

static void ended(plugin_id id, void *unused) {
    (void)id, (void)unused;
    const char *path = getenv("BLOCKS");
    FILE *file = path ? fopen(path, "w") : NULL;
    uint64_t sum = 0;
    for (struct block *block = blocks; block; block = block->next) {
        sum += block->instructions * block->runs;
        if (file && block->runs)
            fprintf(file, "%" PRIx64 " %" PRIu64 " %" PRIu64 "\n", block->address, block->instructions, block->runs);
    }
    if (file)
        fclose(file);
    fprintf(stderr, "instructions: %" PRIu64 "\n", sum);
}

int qemu_plugin_install(plugin_id id, const void *info, int n_arguments, char **arguments) {
    (void)info, (void)n_arguments, (void)arguments;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, ended, NULL);
    return 0;
}
