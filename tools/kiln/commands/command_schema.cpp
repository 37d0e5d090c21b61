#include "commands.h"
#include "examples.h"
#include "job/command/job_schema.h"
#include "say.h"

namespace kiln::tool {

void addSchema(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("schema", "Print the JSON Schema of jobs, for editors and checks.");
  addExamples(*command, {"kiln schema > job.schema.json"});
  command->callback([&context] { context.action = [] { sayJson(jobSchemaText()); }; });
}

}  // namespace kiln::tool
