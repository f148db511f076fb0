// SPDX-License-Identifier: GPL-3.0-or-later
//
// A job type for Flamenco, Blender's own farm manager: a batch of smooth lines, cut into shards that workers take.
// Put it into the folder `scripts` beside the Flamenco Manager. Holds no logic of the batch: it only writes commands.

const JOB_TYPE = {
    label: "Smooth Polylines Batch",
    description: "The same smooth lines on the meshes of many files, as a job in JSON describes them",
    settings: [
        {
            key: "job_file", type: "string", subtype: "file_path", required: true, label: "Job",
            description: "The job (JSON), on storage that all workers see under the same path",
        },
        {
            key: "batch_script", type: "string", subtype: "file_path", required: true, label: "Script",
            description: "batch.py of Smooth Polylines, on storage that all workers see under the same path",
        },
        {
            key: "shards", type: "int32", default: 8, required: true, label: "Tasks",
            description: "Into how many tasks the files are divided; two or three for each worker are a good number",
        },
        {
            key: "processes", type: "int32", default: 1, label: "Processes a Task",
            description: "How many files one worker does at once",
        },
        {
            key: "retry", type: "bool", default: false, label: "Retry Failures",
            description: "Do again what failed before, whatever the reason was",
        },
        {
            key: "blender_cmd", type: "string", default: "{blender}", visible: false,
            description: "Blender with the extension Smooth Polylines",
        },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const shards = settings.shards;
    if (!(shards >= 1)) {
        throw new Error(`Tasks must be 1 or more, found ${shards}`);
    }
    const shardTasks = [];
    for (let number = 1; number <= shards; number++) {
        const options = ["--shard", `${number}/${shards}`, "--jobs", String(Math.max(1, settings.processes || 1))];
        if (settings.retry) {
            options.push("--retry");
        }
        // A file that cannot be done is in the report: no reason for Flamenco to run the whole shard again elsewhere.
        options.push("--failures-ok");
        const task = author.Task(`shard ${number} of ${shards}`, "blender");
        task.addCommand(authorCommand(settings, options));
        job.addTask(task);
        shardTasks.push(task);
    }

    const reportTask = author.Task("report", "misc");
    reportTask.addCommand(authorCommand(settings, ["--report", "--failures-ok"]));
    for (const task of shardTasks) {
        reportTask.addDependency(task);
    }
    job.addTask(reportTask);
}

function authorCommand(settings, options) {
    return author.Command("exec", {
        exe: settings.blender_cmd,
        args: ["--background", "--python-exit-code", "3", "--python", settings.batch_script, "--", settings.job_file]
            .concat(options),
    });
}
